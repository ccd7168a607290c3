// Defines how far away points lie that split the obtuse triangles of the surface.

// Distance in rows and columns, or 0 if no triangle is obtuse. This is a specialization constant: CPU drivers execute
// both sides of a branch, and a variable would double the time of a scan.
layout(constant_id = 6) const int SPLITS = SPLIT_REACH;

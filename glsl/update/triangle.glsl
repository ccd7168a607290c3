// Describes the triangle x0 x1 x2 of an update, for four of them at once: the fronts at x1 and x2, and those
// that arrive at x0.
// Twin: src/update.

// Distance from 1 to the next number.
const float PRECISION = 1.1920929e-7;

// Fronts at x1 or x2 of four triangles.
struct EndFronts {
    vec4 time;
    vec4 carried; // value carried beside the time, depending on the kind of front
    vec4 surface; // surface value there, depending on the kind of front
    vec4 slowness; // slowness there, if it is uneven
};

// Fronts that arrive at x0 of four triangles.
struct Fronts {
    vec4 time;
    vec4 carried;
    bvec4 whole; // came through whole triangles, and are preferred among equal times
};

// The three neighbours that a scan has just visited, as each of four points sees them: the one before the
// point, beside it and after it.
struct NeighboursBehind {
    EndFronts ends[3];
    vec4 edges[3]; // lengths of the edges to them
};

// Returns what a pair of points of a line sees, with each point repeated. It is given the fronts at the four
// points behind, and the edges to the first and to the second end of each triangle. Left triangles are in xy,
// right ones in zw.
NeighboursBehind sight_of_pair(EndFronts behind, vec4 l1, vec4 l2) {
    NeighboursBehind sight;
    sight.ends[0] = EndFronts(behind.time.xyxy, behind.carried.xyxy, behind.surface.xyxy, behind.slowness.xyxy);
    sight.ends[1] = EndFronts(behind.time.yzyz, behind.carried.yzyz, behind.surface.yzyz, behind.slowness.yzyz);
    sight.ends[2] = EndFronts(behind.time.zwzw, behind.carried.zwzw, behind.surface.zwzw, behind.slowness.zwzw);
    sight.edges[0] = l1.xyxy;
    sight.edges[1] = l1.zwzw;
    sight.edges[2] = l2.zwzw;
    return sight;
}

// The places of four points of an update: the first, the steps from it to the second and to the third, and
// the scan's steps. The fourth point lies beyond both.
struct Places {
    ivec2 first, to_second, to_third;
    ivec2 ahead, along;
};

bvec4 both(bvec4 a, bvec4 b) {
    return bvec4(uvec4(a) & uvec4(b));
}

bvec4 either(bvec4 a, bvec4 b) {
    return bvec4(uvec4(a) | uvec4(b));
}

uint largest(uvec4 values) {
    return max(max(values.x, values.y), max(values.z, values.w));
}

// Returns the arrival time along an edge, the Dijkstra step (paper, eq. 16).
vec4 edge_step(vec4 t1, vec4 t2, vec4 l1, vec4 l2) {
    return min(t1 + l1, t2 + l2);
}

// The shape of a triangle in units of its base, seen from one end of the base.
struct Shape {
    vec4 per_base;       // 1 over the length of the base
    vec4 side;           // from this end of the base to x0
    vec4 other;          // from the other end to x0
    vec4 foot;           // from this end to the foot of x0 on the base
    vec4 height_squared; // of x0 over the base
    bvec4 whole;         // all three edges exist and enclose an area
};

// Returns the shapes of triangles from the lengths of their edges.
Shape shape_of(vec4 side, vec4 other, vec4 base) {
    Shape shape;
    shape.per_base = 1.0 / base;
    shape.side = side * shape.per_base;
    shape.other = other * shape.per_base;
    shape.foot = 0.5 * ((shape.side * shape.side - shape.other * shape.other) + 1.0);
    shape.height_squared = (shape.side - shape.foot) * (shape.side + shape.foot);
    // This tests the lengths. Where edges are missing, the height is NaN, and devices may take comparisons
    // with NaN for true.
    bvec4 exists = lessThan(max(max(side, other), base), vec4(FAR));
    shape.whole = both(greaterThan(shape.height_squared, vec4(0.0)), exists);
    return shape;
}

// Returns whether no angle is obtuse by more than a few degrees.
bvec4 are_upright(Shape shape) {
    vec4 side = shape.side * shape.side;
    vec4 other = shape.other * shape.other;
    vec4 longest = max(max(side, other), 1.0);
    return lessThan(longest, UPRIGHT * (side + other + 1.0 - longest));
}

// Triangles as seen from both ends of their bases. An update can be prepared with them before the times at x1
// and x2 are known, and with them the end that counts.
struct Face {
    vec4 l1, l2, base;
    Shape from_x1, from_x2;
    vec4 height_x1, height_x2; // of x0 over the base, as seen from each end
    bvec4 upright;
};

// Returns the faces of triangles. Of obtuse ones only the edges count.
Face face_of(vec4 l1, vec4 l2, vec4 base, bvec4 obtuse) {
    Shape from_x1 = shape_of(l1, l2, base);
    Shape from_x2 = shape_of(l2, l1, base);
    from_x1.whole = both(from_x1.whole, not(obtuse));
    from_x2.whole = both(from_x2.whole, not(obtuse));
    return Face(l1, l2, base, from_x1, from_x2, sqrt(max(from_x1.height_squared, 0.0)),
                sqrt(max(from_x2.height_squared, 0.0)), are_upright(from_x1));
}

// Returns the shapes as seen from x2 where `second` is set, and from x1 elsewhere. They are equal to the last
// bit to those that shape_of() returns.
Shape seen_from(Face face, bvec4 second) {
    Shape a = face.from_x1;
    Shape b = face.from_x2;
    return Shape(a.per_base, mix(a.side, b.side, second), mix(a.other, b.other, second), mix(a.foot, b.foot, second),
                 mix(a.height_squared, b.height_squared, second),
                 either(both(second, b.whole), both(not(second), a.whole)));
}

// Returns whether triangles of one slowness are obtuse at x0.
bvec4 are_obtuse(vec4 l1, vec4 l2, vec4 c) {
    vec4 per_base = 1.0 / c;
    vec4 side = l1 * per_base;
    vec4 other = l2 * per_base;
    return both(lessThan(c, vec4(FAR)), lessThan(side * side + other * other, vec4(OBTUSE)));
}

// Returns whether only the one of x1 and x2 across the grid's diagonal is present, given the edges to the
// other, along an axis of the grid. Fronts are then assumed to have come around a hole's corner.
bvec4 are_alone(vec4 beside) {
    return greaterThanEqual(beside, vec4(FAR));
}

// Describes the triangle x0 x1 x2 of an update, for four of them at once: the fronts at x1 and x2, and those
// that arrive at x0.
// Twin: src/update.

// Distance from 1 to the next larger float. It is the relative rounding of times: one unit of the last place.
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

// Returns the neighbours behind a pair of points of a line. The first point is in x and z of the result, the second one
// in y and w. `behind` has the fronts at the four points behind the pair. `l1` and `l2` are the lengths of the edges to
// the first and to the second end of each triangle: left triangles in xy, right ones in zw.
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

// Grid positions of the four points of an update. `to_second` and `to_third` are the steps from the first point to the
// second and the third. The step to the fourth is the sum of both. `ahead` and `along` are the scan's steps.
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

// The shape of a triangle, measured from one end of its base. Lengths are in units of the base.
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
    // The test is on the lengths. Where edges are missing, the height is NaN, and comparisons with NaN may be true on
    // some devices.
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

// Triangles as seen from both ends of their bases. Which end an update needs depends on the times at x1 and x2. With
// both prepared, the shapes are computed before these times are known.
struct Face {
    vec4 l1, l2, base;
    Shape from_x1, from_x2;
    vec4 height_x1, height_x2; // of x0 over the base, as seen from each end
    bvec4 upright;
};

// Returns the triangles with these edges as faces. Only the edges of obtuse triangles are used.
Face face_of(vec4 l1, vec4 l2, vec4 base, bvec4 obtuse) {
    Shape from_x1 = shape_of(l1, l2, base);
    Shape from_x2 = shape_of(l2, l1, base);
    from_x1.whole = both(from_x1.whole, not(obtuse));
    from_x2.whole = both(from_x2.whole, not(obtuse));
    return Face(l1, l2, base, from_x1, from_x2, sqrt(max(from_x1.height_squared, 0.0)),
                sqrt(max(from_x2.height_squared, 0.0)), are_upright(from_x1));
}

// Returns the shapes as seen from x2 where `second` is set, and from x1 elsewhere. They equal those of shape_of() to
// the last bit.
Shape seen_from(Face face, bvec4 second) {
    Shape a = face.from_x1;
    Shape b = face.from_x2;
    return Shape(a.per_base, mix(a.side, b.side, second), mix(a.other, b.other, second), mix(a.foot, b.foot, second),
                 mix(a.height_squared, b.height_squared, second),
                 either(both(second, b.whole), both(not(second), a.whole)));
}

// Returns whether triangles are obtuse at x0, if the slowness is the same at all their corners.
bvec4 are_obtuse(vec4 l1, vec4 l2, vec4 c) {
    vec4 per_base = 1.0 / c;
    vec4 side = l1 * per_base;
    vec4 other = l2 * per_base;
    return both(lessThan(c, vec4(FAR)), lessThan(side * side + other * other, vec4(OBTUSE)));
}

// Returns where the neighbour along an axis of the grid is missing, given the edges `beside` to it. Of x1 and x2, only
// the one across the grid's diagonal is then present. Fronts from there are assumed to have turned around the corner
// of a hole.
bvec4 are_alone(vec4 beside) {
    return greaterThanEqual(beside, vec4(FAR));
}

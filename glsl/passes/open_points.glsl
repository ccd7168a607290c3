// Converts the points of a grid that is not glued. Include after points.glsl.

void main() {
    ivec2 place = ivec2(gl_GlobalInvocationID.xy);
    if (is_beyond(place, ivec2(grid.x, band_rows))) return;
    ivec2 at = place + ivec2(0, first_row);
    bool present = is_given(at);
    write_point(row_major(place, grid.x), at, present);
    if (!present) count_hole(place.y);
}

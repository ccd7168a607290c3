// Declares the band of rows whose edges a dispatch measures. Large surfaces are measured band by band, since a device
// limits how much of a buffer a shader can access at once.

layout(push_constant) uniform Band {
    ivec2 grid;      // columns and rows of the whole grid
    ivec2 halo;      // columns and rows of points that the buffer holds beyond each side; 0 where the grid ends
    int first_row;   // the band's first row
    int band_rows;   // number of rows in the band
    int buffer_row;  // the grid row with which the buffer starts
    float dx;        // spacing of a height field's columns
    float dy;        // spacing of a height field's rows
    int arcs;        // 0 for chords, 1 for lengths along the surface, WITH_CORNERS if grid lines have corners too
    int slowed;      // 1 if the slowness is stored beside the Gaussian curvature; see surface_image.glsl
};

int buffer_index(ivec2 at) {
    return row_major(at + ivec2(halo.x, -buffer_row), grid.x + 2 * halo.x);
}

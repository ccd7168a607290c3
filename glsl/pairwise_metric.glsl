// What the update by anchors knows of a floor plan beside its grid points, where these are the sources.

// The metric: of rows, of both, of columns.
layout(constant_id = 10) const float METRIC_RR = 1.0;
layout(constant_id = 11) const float METRIC_RC = 0.0;
layout(constant_id = 12) const float METRIC_CC = 1.0;

vec3 metric() {
    return vec3(METRIC_RR, METRIC_RC, METRIC_CC);
}

vec4 source_inside(uint number) {
    return vec4(0.0);
}

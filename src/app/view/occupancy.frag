// The space-time occupancy: cells of observed space whose centre is warped into an occupied canonical cell
// (render/occupancy.cpp).
uniform sampler3D canonical;
uniform vec3 gridOrigin, boxHi;
uniform float cell;
uniform ivec3 gridSize;
out vec4 occupied;

void main() {
  vec3 x = min(gridOrigin + cell * (vec3(cellOf(ivec2(gl_FragCoord.xy), gridSize)) + 0.5), boxHi);
  ivec3 c = ivec3((x + displacement(x) - gridOrigin) / cell);
  occupied = texelFetch(canonical, clamp(c, ivec3(0), gridSize - 1), 0);
}

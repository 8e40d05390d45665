// The space-time occupancy: cells of observed space whose centre is warped into an occupied canonical cell
// (render/occupancy.cpp).
// r: the canonical cell is occupied; g: this cell of observed space is at some time
uniform sampler3D canonical;
uniform vec3 gridOrigin, boxHi;
uniform float cell;
uniform ivec3 gridSize;
out vec4 occupied;

void main() {
  ivec3 here = cellOf(ivec2(gl_FragCoord.xy), gridSize);
  occupied = vec4(0.0);
  if (here.z >= gridSize.z || texelFetch(canonical, here, 0).g == 0.0) return;
  vec3 x = min(gridOrigin + cell * (vec3(here) + 0.5), boxHi);
  ivec3 c = ivec3((x + displacement(x) - gridOrigin) / cell);
  occupied = texelFetch(canonical, clamp(c, ivec3(0), gridSize - 1), 0).rrrr;
}

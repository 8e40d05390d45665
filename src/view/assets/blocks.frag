// The blocks of 4^3 cells: occupied where any cell is, so that a ray crosses empty space in long steps.
uniform sampler2D cells;
uniform ivec3 gridSize, blockSize;
out vec4 occupied;

void main() {
  ivec3 first = 4 * cellOf(ivec2(gl_FragCoord.xy), blockSize), last = min(first + 4, gridSize);
  float any = 0.0;
  for (int z = first.z; z < last.z; ++z)
    for (int y = first.y; y < last.y; ++y)
      for (int x = first.x; x < last.x; ++x)
        any = max(any, texelFetch(cells, tileOf(ivec3(x, y, z), gridSize), 0).r);
  occupied = vec4(any);
}

// One layer of the slice: the control points of every motion vertex, contracted with the weights of one time
// (field/lattice/slice.cpp).
uniform highp usampler3D table;     // brick of a place in the ring, 0 = absent, else number + 1
uniform highp isampler2D points;    // texel of (number k, row r): k * rows + r; x, y, z of a control point
uniform int rows, layer, first, count;
uniform float weights[20];          // basis weight times the scale of the number's displacement
uniform int scalarNumber;           // from here on a point of each curve of one number, -1: there are none
uniform vec4 scalarWeights[20];
uniform float rigidityScale;
uniform int rigidityNumber;         // the last number's x, -1: there is none
uniform float rigidityBackground;
layout(location = 0) out vec4 motion;  // displacement, raw rigidity
layout(location = 1) out vec4 scalars;

ivec4 point(int number, int row) {
  int at = number * rows + row;
  int width = textureSize(points, 0).x;
  return texelFetch(points, ivec2(at % width, at / width), 0);
}

void main() {
  motion = vec4(0.0, 0.0, 0.0, rigidityBackground);
  scalars = vec4(0.0);
  ivec3 vertex = ivec3(ivec2(gl_FragCoord.xy), layer);
  int brick = int(texelFetch(table, vertex / 8 + 1, 0).r);
  if (brick == 0) return;
  ivec3 local = vertex & 7;
  int row = (brick - 1) * 512 + local.x * 64 + local.y * 8 + local.z;
  for (int k = 0; k < count; ++k) motion.xyz += weights[k] * vec3(point(first + k, row).xyz);
  if (scalarNumber >= 0)
    for (int k = 0; k < count; ++k) scalars += scalarWeights[k] * vec4(point(scalarNumber + first + k, row));
  if (rigidityNumber >= 0) motion.w = rigidityScale * float(point(rigidityNumber, row).x);
}

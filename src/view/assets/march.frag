// One ray a pixel through the model at the slice's time: the march of render/ray_kernel.hpp, sample for
// sample, and the colours of run/colours.cpp for what is no colour.
uniform highp usampler3D bricks;    // place in the ring -> place in the atlas, w = 0: absent
uniform sampler3D atlas;            // raw density, raw colour; 9^3 bricks, their neighbours' first vertices
#if SH_TEXTURES > 0
uniform sampler3D harmonics[SH_TEXTURES];
uniform vec2 harmonicRange;         // lo, hi - lo
#endif
#if PARTS
uniform sampler3D parts;            // colour of the part of a canonical cell, transparent: it is of none
uniform vec3 partOrigin;
uniform float partInverseSpacing;
#endif
uniform sampler2D cells, blocks;    // occupancy of observed space at this time
uniform vec3 gridOrigin;
uniform float inverseCell;
uniform ivec3 gridSize, blockSize;
uniform vec3 boxLo, boxHi;
uniform vec3 ringOrigin, ringLimit;
uniform float inverseSpacing, densityScale, densityShift;
uniform float stepLength, stopAt;
uniform vec3 eye, axisX, axisY, axisZ;
uniform vec4 lens;                  // 1 / fx, 1 / fy, cx, cy: pixels of the target
uniform float targetHeight;
uniform int shown;                  // 0 rgb, 1 depth, 2 flow, 3 rigidity, 4 cluster: kLayers of layers.js
uniform vec3 background;
#if BACKGROUND_ORDER >= 0
// Raw r, g, b of every coefficient.
uniform vec3 backgroundHarmonics[(BACKGROUND_ORDER + 1) * (BACKGROUND_ORDER + 1)];
uniform bool learnedBackground;     // false: another colour was picked
#endif
uniform vec2 depthRange;
uniform float fullFlow;
out vec4 colour;

float softplus(float x) { return max(x, 0.0) + log(1.0 + exp(-abs(x))); }

#if SH_TEXTURES > 0
/// 1 - sigmoid(q) / 2 (math/view_factor.hpp).
float viewFactor(vec3 at, vec4 y[SH_TEXTURES]) {
  float q = 0.0;
  q += dot(y[0], harmonicRange.x + harmonicRange.y * texture(harmonics[0], at));
#if SH_TEXTURES > 1
  q += dot(y[1], harmonicRange.x + harmonicRange.y * texture(harmonics[1], at));
  q += dot(y[2], harmonicRange.x + harmonicRange.y * texture(harmonics[2], at));
#endif
#if SH_TEXTURES > 3
  q += dot(y[3], harmonicRange.x + harmonicRange.y * texture(harmonics[3], at));
#endif
  return 1.0 - 0.5 * sigmoid(q);
}

/// math/sh.hpp; coefficients that the model lacks are 0.
void harmonicsOf(vec3 d, out vec4 y[SH_TEXTURES]) {
  y[0] = vec4(0.28209479177387814, 0.0, 0.0, 0.0);
#if SH_ORDER > 0
  y[0].yzw = 0.4886025119029199 * d.yzx;
#endif
#if SH_ORDER > 1
  vec3 s = d * d;
  const float b = 1.0925484305920792;
  y[1] = vec4(b * d.x * d.y, b * d.y * d.z, 0.31539156525252005 * (3.0 * s.z - 1.0), b * d.x * d.z);
  y[2] = vec4(0.5462742152960396 * (s.x - s.y), 0.0, 0.0, 0.0);
#endif
#if SH_ORDER > 2
  y[2].yzw = vec3(0.5900435899266435 * d.y * (3.0 * s.x - s.y), 2.890611442640554 * d.x * d.y * d.z,
                  0.4570457994644658 * d.y * (5.0 * s.z - 1.0));
  y[3] = vec4(0.3731763325901154 * d.z * (5.0 * s.z - 3.0), 0.4570457994644658 * d.x * (5.0 * s.z - 1.0),
              1.445305721320277 * d.z * (s.x - s.y),
              0.5900435899266435 * d.x * (s.x - 3.0 * s.y));
#endif
}
#endif

/// math/background_color.hpp
vec3 behind(vec3 d) {
#if BACKGROUND_ORDER < 0
  return background;
#else
  if (!learnedBackground) return background;
  vec3 q = 0.28209479177387814 * backgroundHarmonics[0];
#if BACKGROUND_ORDER > 0
  q += 0.4886025119029199 *
       (d.y * backgroundHarmonics[1] + d.z * backgroundHarmonics[2] + d.x * backgroundHarmonics[3]);
#endif
#if BACKGROUND_ORDER > 1
  vec3 s = d * d;
  const float b = 1.0925484305920792;
  q += b * (d.x * d.y * backgroundHarmonics[4] + d.y * d.z * backgroundHarmonics[5] +
            d.x * d.z * backgroundHarmonics[7]);
  q += 0.31539156525252005 * (3.0 * s.z - 1.0) * backgroundHarmonics[6] +
       0.5462742152960396 * (s.x - s.y) * backgroundHarmonics[8];
#endif
#if BACKGROUND_ORDER > 2
  q += 0.5900435899266435 * (d.y * (3.0 * s.x - s.y) * backgroundHarmonics[9] +
                             d.x * (s.x - 3.0 * s.y) * backgroundHarmonics[15]);
  q += 2.890611442640554 * d.x * d.y * d.z * backgroundHarmonics[10] +
       1.445305721320277 * d.z * (s.x - s.y) * backgroundHarmonics[14];
  q += 0.4570457994644658 * (5.0 * s.z - 1.0) *
       (d.y * backgroundHarmonics[11] + d.x * backgroundHarmonics[13]);
  q += 0.3731763325901154 * d.z * (5.0 * s.z - 3.0) * backgroundHarmonics[12];
#endif
  return 1.0 / (1.0 + exp(-q));
#endif
}

/// Steps to the end of the block of `size` cells around cell position c, at least one.
int across(vec3 c, vec3 perStep, ivec3 cell, int size) {
  vec3 lo = vec3((cell / size) * size), hi = lo + float(size);
  vec3 left = vec3(perStep.x > 0.0 ? hi.x - c.x : lo.x - c.x, perStep.y > 0.0 ? hi.y - c.y : lo.y - c.y,
                   perStep.z > 0.0 ? hi.z - c.z : lo.z - c.z);
  vec3 n = mix(left / perStep, vec3(1e9), lessThan(abs(perStep), vec3(1e-9)));
  return max(1, int(ceil(min(n.x, min(n.y, n.z)))));
}

vec3 depthRamp(float t) {
  float s = clamp(t, 0.0, 1.0) * 4.0;
  int i = min(int(s), 3);
  return mix(kDepth[i], kDepth[i + 1], s - float(i));
}

void main() {
  vec2 pixel = vec2(gl_FragCoord.x, targetHeight - gl_FragCoord.y);
  vec2 p = (pixel - lens.zw) * lens.xy;
  vec3 direction = normalize(p.x * axisX - p.y * axisY - axisZ);
  vec3 back = behind(direction);
  colour = vec4(shown == 0 || shown == 4 ? back : background, 1.0);

  vec3 safe = mix(direction, vec3(1e-20), equal(direction, vec3(0.0)));
  vec3 a = (boxLo - eye) / safe, b = (boxHi - eye) / safe;
  vec3 enter = min(a, b), leave = max(a, b);
  float near = max(max(enter.x, enter.y), max(enter.z, 0.0)), far = min(leave.x, min(leave.y, leave.z));
  float start = near + 0.5 * stepLength;
  if (far <= near || start > far) return;
  int samples = int((far - start) / stepLength) + 1;
  vec3 origin = eye + start * direction, advance = stepLength * direction;
  vec3 cellOrigin = (origin - gridOrigin) * inverseCell, cellAdvance = advance * inverseCell;

#if SH_TEXTURES > 0
  vec4 y[SH_TEXTURES];
  harmonicsOf(direction, y);
#endif
  vec3 atlasScale = 1.0 / vec3(textureSize(atlas, 0));
  vec3 rgb = vec3(0.0), flow = vec3(0.0);
  float through = 1.0, weights = 0.0, depth = 0.0, moves = 0.0;
  for (int i = 0; i < samples;) {
    vec3 c = cellOrigin + float(i) * cellAdvance;
    ivec3 cell = clamp(ivec3(c), ivec3(0), gridSize - 1);
    if (texelFetch(blocks, tileOf(cell >> 2, blockSize), 0).r == 0.0) {
      i += across(c, cellAdvance, cell, 4);
      continue;
    }
    if (texelFetch(cells, tileOf(cell, gridSize), 0).r == 0.0) {
      i += across(c, cellAdvance, cell, 1);
      continue;
    }
    vec3 x = origin + float(i) * advance;
    float distance = start + float(i) * stepLength;
    ++i;
    float gain = 1.0, presence = 0.0, r = 1.0;
    vec3 delta = motionAt(x, gain, presence, r);
    vec3 u = clamp((x + delta - ringOrigin) * inverseSpacing, vec3(0.0), ringLimit);
    ivec3 brick = ivec3(u) / 8;
    uvec4 place = texelFetch(bricks, brick, 0);
    if (place.w == 0u) continue;
    vec3 at = (9.0 * vec3(place.xyz) + (u - 8.0 * vec3(brick)) + 0.5) * atlasScale;
    vec4 raw = texture(atlas, at);
    // emission_of and opacity_of (math/emission.hpp, math/composite.hpp)
    float thickness = densityScale * softplus(raw.x + presence + densityShift) * stepLength;
    if (thickness < 1e-6) continue;
    float passed = exp(-thickness), w = through * (1.0 - passed);
    vec3 seen = gain / (1.0 + exp(-raw.yzw));
#if SH_TEXTURES > 0
    seen *= viewFactor(at, y);
#endif
#if PARTS
    if (shown == 4) {
      vec3 inParts = (x + delta - partOrigin) * partInverseSpacing + 0.5;
      vec4 part = texture(parts, inParts / vec3(textureSize(parts, 0)));
      if (part.a > 0.5) seen = gain * part.rgb;
    }
#endif
    rgb += w * seen;  // composite_sample, and PixelSums (render/pixel_sums.hpp)
    weights += w, depth += w * distance;
    flow += w * delta, moves += w * r;
    through *= passed;
    if (through < stopAt) break;
  }
  float alpha = 1.0 - through;
  if (shown == 0 || shown == 4) {
    colour.rgb = rgb + through * back;
    return;
  }
  if (alpha <= 1e-3) return;
  vec3 paint;
  if (shown == 1) {
    // PixelDepth::mean
    float z = weights > 1e-4 ? -dot(direction, axisZ) * depth / weights : 0.0;
    paint = depthRamp((z - depthRange.x) / max(depthRange.y - depthRange.x, 1e-6));
  } else if (shown == 2) {
    vec3 d = flow / alpha;
    float n = length(d);
    paint = vec3(0.5) + (n > 0.0 ? d * (0.5 * min(n / fullFlow, 1.0) / n) : vec3(0.0));
  } else {
    float s = clamp(moves / alpha, 0.0, 1.0) * 2.0;
    paint = s < 1.0 ? mix(kMoves[0], kMoves[1], s) : mix(kMoves[1], kMoves[2], s - 1.0);
  }
  colour.rgb = mix(background, paint, alpha);
}

/** GLSL of a depth camera's pixels: where their points are, and where these make a surface. */

/** Along a surface depth changes by at most so many times the distance between its points: 83°. */
export const STEEPEST = 8;

export const LATTICE = /* glsl */ `
precision highp usampler2D;
uniform usampler2D depths;      // of each pixel, in units; 0 without a point
uniform usampler2D labels;
uniform sampler2D colours;      // bytes of the picture, in rows as long as the image's
uniform ivec4 planes[3];        // see Colours
uniform ivec2 picture;          // pixels from one of the picture's to the next, 0 without; 1: luma and chroma
uniform ivec4 grids[2];         // of points, and of the surface: columns, rows, pixels between these
uniform mat4 rays;              // T_local_pixel: of 1, a depth, the depth times column and row
uniform vec2 steps;             // at one unit of depth: metres between neighbours; units on the steepest surface
#ifdef PLACED
// Objects in it are placed separately from their surroundings: no surface connects the two.
#define surfaceOn false
#else
#define surfaceOn (settings[8].w > 0.5)
#endif

ivec4 grid;

ivec2 pixelOf() {
#ifdef SURFACE
  int columns = grid.x;
#else
  int columns = grids[0].x;
#endif
  return ivec2(gl_VertexID % columns, gl_VertexID / columns) * grid.zw;
}

float depthAt(ivec2 pixel) {
  ivec2 size = textureSize(depths, 0);
  if (any(lessThan(pixel, ivec2(0))) || any(greaterThanEqual(pixel, size))) return 0.0;
  return float(texelFetch(depths, pixel, 0).r);
}

float between() { return sqrt(float(grid.z * grid.w)); }

// Whether no surface goes from a pixel to a neighbour, which is nearer.
bool isNearer(float other, float depth) {
  return other > 0.0 && depth - other > 1.5 + steps.y * between() * other;
}

bool meets(float other, float depth) {
  return other > 0.0 && !isNearer(other, depth) && !isNearer(depth, other);
}

// A pixel behind its neighbour's edge is no part of the surface: no triangle reaches over an edge.
bool isCut(ivec2 pixel, float depth) {
  bool found = false;
  for (int i = 0; i < 6; i++) {
    ivec2 way = i < 2 ? ivec2(2 * i - 1, 0) : i < 4 ? ivec2(0, 2 * i - 5) : ivec2(2 * i - 9, 9 - 2 * i);
    found = found || isNearer(depthAt(pixel + way * grid.zw), depth);
  }
  return found;
}

// The nearest pixel with a point that way, or the pixel itself where the second has none either.
ivec2 pixelTowards(ivec2 pixel, ivec2 way) {
  if (depthAt(pixel + way) > 0.0) return pixel + way;
  return depthAt(pixel + 2 * way) > 0.0 ? pixel + 2 * way : pixel;
}

// Close a hole of two pixels at most in one surface with one label: its ends, and its depth or 0.
float closed(ivec2 pixel, out ivec2 ends[2]) {
  for (int i = 0; i < 2; i++) {
    ivec2 way = i == 0 ? ivec2(grid.z, 0) : ivec2(0, grid.w);
    ends = ivec2[](pixelTowards(pixel, -way), pixelTowards(pixel, way));
    float here = depthAt(ends[0]), there = depthAt(ends[1]);
    if (here == 0.0 || !meets(there, here)) continue;
    if (texelFetch(labels, ends[0], 0).r != texelFetch(labels, ends[1], 0).r) continue;
    vec2 away = vec2(length(vec2(pixel - ends[0])), length(vec2(ends[1] - pixel)));
    return (here * away.y + there * away.x) / (away.x + away.y);
  }
  return 0.0;
}

vec3 placeOf(ivec2 pixel, float depth) {
  return (rays * vec4(1.0, depth, depth * vec2(pixel))).xyz;
}

float byteAt(int plane, ivec2 at) {
  ivec4 way = planes[plane];
  int place = way.x + at.y / (way.z >> 4) * way.y + at.x / (way.z & 15) * way.w;
  int width = textureSize(colours, 0).x;
  return texelFetch(colours, ivec2(place % width, place / width), 0).r;
}

vec4 colourOf(ivec2 pixel) {
  if (picture.x == 0) return vec4(0.0);
  ivec2 at = pixel / picture.x;
  vec3 found = vec3(byteAt(0, at), byteAt(1, at), byteAt(2, at));
  if (picture.y == 0) return vec4(found, 0.0);
  vec2 chroma = found.yz - 128.0 / 255.0;
  vec3 rgb = found.x + vec3(1.402 * chroma.y, dot(vec2(-0.344136, -0.714136), chroma), 1.772 * chroma.x);
  return vec4(clamp(rgb, 0.0, 1.0), 0.0);
}
`;

/** After the test for hidden points: whether a pixel is drawn, as a point or in the surface. */
export const LATTICE_DRAWN = /* glsl */ `
// Whether a neighbour carries the surface on: it is neither hidden nor behind an edge on its far side.
bool carries(ivec2 pixel, ivec2 way, float depth) {
  ivec2 next = pixel + way;
  float there = depthAt(next);
  if (!meets(there, depth) || isNearer(depthAt(next + way), there)) return false;
  return !isHidden(int(texelFetch(labels, next, 0).r), placeOf(next, there));
}

bool isDrawn(ivec2 pixel, float depth) {
  if (depth == 0.0) return false;
#ifdef SURFACE
  return !isCut(pixel, depth);
#else
  if (!surfaceOn || isCut(pixel, depth)) return true;
  ivec2 across = ivec2(grid.z, 0), down = ivec2(0, grid.w);
  return !(carries(pixel, across, depth) || carries(pixel, -across, depth))
    || !(carries(pixel, down, depth) || carries(pixel, -down, depth));
#endif
}
`;

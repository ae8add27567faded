/** GLSL of the points and of eye-dome lighting. */
import { LATTICE, LATTICE_DRAWN } from './lattice/shader';

/** Vectors of four numbers in the points' settings. */
export const SETTING_ROWS = 13;

/** Part of the ramp that is too dark to be seen before the room. */
const RAMP_START = 0.32;

export const POINT_VERTEX = /* glsl */ `
precision highp float;
precision highp int;
precision highp sampler2D;

#ifdef LATTICE
vec4 colour;
uniform int sensor;
#else
in vec3 quantised;
in vec4 colour;      // r, g, b, intensity
in float stamp;      // chunk * 64 + size code
in float label;
uniform sampler2D chunkTable;   // row per chunk: origin + density factor; scale + sensor; the sensor's place
uniform int chunkRow;           // >= 0: every point of this draw is of this chunk
#endif

uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform sampler2D palette;      // texel per label: colour, flags
#ifdef PLACED
uniform mat4 placed;            // of a frame that is laid over the one on screen
uniform sampler2D moving;       // row per label that lies elsewhere: rows of its transform; its id
uniform int movingCount;
#endif
uniform vec4 settings[${SETTING_ROWS}];    // all else, in the order of material.ts

#define pixelsPerMetre settings[0].x            // at distance 1: viewport height / 2 * point size setting
#define pixelLimits settings[0].yz
#define gain settings[0].w
#define colourMode int(settings[1].x)           // 0 rgb, 1 intensity, 2 height, 3 plain, 4 distance, 5 normal, 6 label, 7 sensor
#define hasIntensity int(settings[1].y)
#define labelBlend settings[1].z
#define hideUnlabeled int(settings[1].w)
#define heightRow settings[2]                   // local xyz1 -> height 0..1
#define brushA settings[3].xyz
#define brushRadius settings[3].w
#define brushB settings[4].xyz
#define brushMode int(settings[4].w)            // 0 none, 1 capsule a-b, 2 half-line from a along b
#define brushColour settings[5].xyz
#define brushOnlyUnlabeled int(settings[5].w)
#define showDeleted int(settings[6].x)
#define distanceScale settings[7].w             // 1 / the greatest distance from a sensor
#define rampLow settings[8].x
#define rampScale settings[8].y
#define rampKind int(settings[8].z)             // 0 even, 1 grey, 2 rainbow
#define intensityFit settings[9].xy             // intensity -> 0..1 of the ramp: factor, then sum
#define clipX settings[10]                      // local xyz1 -> -1..1 between two faces of the clip box
#define clipY settings[11]
#define clipZ settings[12]
#define pulse settings[6].y                     // 0..1, of labels that a person should look at
#define outlining settings[6].w                 // 1: alpha marks the points of a click's candidate
#define mapping int(settings[9].z)              // 1: classes, shaded; 2: the recording's colours alone
#define severalSensors (settings[9].w > 0.5)

out vec4 shade;
#ifndef SURFACE
flat out float pixels;
#endif

vec3 ramp(float t) {
  t = clamp((t - rampLow) * rampScale, 0.0, 1.0);
  if (rampKind == 1) return vec3(0.12 + 0.88 * t);
  if (rampKind == 2) {
    // Turbo (Mikhailov 2019), fitted.
    vec4 powers = vec4(1.0, t, t * t, t * t * t);
    vec2 high = powers.zw * powers.z;
    return vec3(
      dot(powers, vec4(0.1357, 4.6154, -42.6603, 132.1311)) + dot(high, vec2(-152.9424, 59.2864)),
      dot(powers, vec4(0.0914, 2.1942, 4.8430, -14.1850)) + dot(high, vec2(4.2773, 2.8296)),
      dot(powers, vec4(0.1067, 12.6419, -60.5820, 110.3628)) + dot(high, vec2(-89.9031, 27.3482)));
  }
  // A perceptually even ramp (viridis, fitted), from where it is light enough for a dark room.
  t = mix(${RAMP_START.toFixed(2)}, 1.0, t);
  vec3 c0 = vec3(0.2777, 0.0054, 0.3341), c1 = vec3(0.1051, 1.4046, 1.3846);
  vec3 c2 = vec3(-0.3309, 0.2148, 0.0951), c3 = vec3(-4.6342, -5.7991, -19.3324);
  vec3 c4 = vec3(6.2283, 14.1799, 56.6906), c5 = vec3(4.7764, -13.7451, -65.3530);
  vec3 c6 = vec3(-5.4355, 4.6459, 26.3124);
  return c0 + t * (c1 + t * (c2 + t * (c3 + t * (c4 + t * (c5 + t * c6)))));
}

// Lightness of the point in the recording, 0..1: of its colour, else its intensity.
float lightness() {
  if (colour.rgb != vec3(0.0)) return dot(colour.rgb, vec3(0.299, 0.587, 0.114));
  return hasIntensity == 0 ? 0.5 : clamp(colour.a * intensityFit.x + intensityFit.y, 0.0, 1.0);
}

bool underBrush(vec3 p) {
  if (brushMode == 0) return false;
  vec3 offset = p - brushA;
  if (brushMode == 1) {
    vec3 axis = brushB - brushA;
    float length2 = dot(axis, axis);
    if (length2 > 0.0) offset -= axis * clamp(dot(offset, axis) / length2, 0.0, 1.0);
  } else {
    float along = dot(offset, brushB);
    if (along < 0.0) return false;
    offset -= along * brushB;
  }
  return dot(offset, offset) <= brushRadius * brushRadius;
}

vec4 entryOf(int id) { return texelFetch(palette, ivec2(id & 255, id >> 8), 0); }
int flagsOf(vec4 entry) { return int(entry.a * 255.0 + 0.5); }
bool isPredicted(int id, int flags) { return id != 65535 && (flags & 8) != 0; }

// A point with a label at a place of its own frame.
bool isHidden(int id, vec3 position) {
  int flags = flagsOf(entryOf(id));
  bool hidden = id == 65535 ? showDeleted == 0
    : id == 0 || isPredicted(id, flags) ? hideUnlabeled != 0 : (flags & 128) == 0;
  vec4 place = vec4(position, 1.0);
  vec3 inBox = abs(vec3(dot(clipX, place), dot(clipY, place), dot(clipZ, place)));
  return hidden || any(greaterThan(inBox, vec3(1.0)));
}

#ifdef LATTICE
${LATTICE}
${LATTICE_DRAWN}
#endif

void leaveOut() {
#ifdef SURFACE
  // So far behind the far plane that of triangles with this corner no area is left before it.
  gl_Position = vec4(0.0, 0.0, 1e15, 1.0);
#else
  gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
  gl_PointSize = 0.0;
#endif
}

void main() {
#ifdef LATTICE
  grid = grids[surfaceOn ? 1 : 0];
  ivec2 pixel = pixelOf();
  float depth = depthAt(pixel);
  ivec2 ends[2] = ivec2[](pixel, pixel);
#ifdef SURFACE
  if (depth == 0.0) depth = closed(pixel, ends);
#endif
  if (!isDrawn(pixel, depth)) {
    leaveOut();
    return;
  }
  colour = 0.5 * (colourOf(ends[0]) + colourOf(ends[1]));
  int id = int(texelFetch(labels, ends[0], 0).r);
  vec3 position = placeOf(pixel, depth);
  float spacing = steps.x * between() * depth;
  float away = colourMode == 4 ? distance(position, rays[0].xyz) : 0.0;
#else
  int word = int(stamp);
  int row = chunkRow >= 0 ? chunkRow : word >> 6;
  vec4 origin = texelFetch(chunkTable, ivec2(0, row), 0);
  vec4 scale = texelFetch(chunkTable, ivec2(1, row), 0);
  int sensor = int(scale.w);
  vec3 position = origin.xyz + quantised * scale.xyz;
  float spacing = 0.0005 * exp2(float(word & 63) * 0.25) * origin.w;
  int id = int(label);
  vec4 eye = colourMode == 4 ? texelFetch(chunkTable, ivec2(2, row), 0) : origin;
  float away = distance(position, eye.xyz);
#endif
#ifdef PLACED
  mat4 at = placed;
  for (int i = 0; i < movingCount; i++) {
    if (int(texelFetch(moving, ivec2(3, i), 0).x) != id) continue;
    at = transpose(mat4(texelFetch(moving, ivec2(0, i), 0), texelFetch(moving, ivec2(1, i), 0),
      texelFetch(moving, ivec2(2, i), 0), vec4(0.0, 0.0, 0.0, 1.0)));
  }
  position = (at * vec4(position, 1.0)).xyz;
#endif
  vec4 ofSensor = severalSensors ? entryOf(65280 + sensor) : vec4(1.0);
  if (isHidden(id, position) || (flagsOf(ofSensor) & 128) == 0) {
    leaveOut();
    return;
  }
  bool deleted = id == 65535;
  vec4 entry = entryOf(id);
  int flags = flagsOf(entry);
  bool predicted = isPredicted(id, flags);
  bool unlabeled = id == 0 || predicted;

  vec3 base;
  if (colourMode == 0) {
    base = colour.rgb;
    // A lidar's point that no camera saw has the colour 0, 0, 0: its intensity stands in.
    if (hasIntensity != 0 && base == vec3(0.0)) base = vec3(0.22 + 0.6 * sqrt(lightness()));
  }
  else if (colourMode == 5) base = colour.rgb;
  else if (colourMode == 1) base = ramp(colour.a * intensityFit.x + intensityFit.y);
  else if (colourMode == 2) base = ramp(dot(heightRow, vec4(position, 1.0)));
  else if (colourMode == 4) base = ramp(away * distanceScale);
  else if (colourMode == 7) base = ofSensor.rgb * mix(0.55, 1.15, lightness());
  else {
    base = vec3(0.72, 0.74, 0.77);
    if (colourMode == 6) base *= mix(0.55, 1.15, lightness());
  }
  base = min(base * gain, vec3(1.0));

  if (deleted) base = mix(base, vec3(0.85, 0.2, 0.2), 0.75) * 0.7;
  else if (mapping == 1 && id != 65344) {
    float height = clamp(dot(heightRow, vec4(position, 1.0)), 0.0, 1.0);
    float tone = 0.58 + 0.3 * lightness() + 0.22 * height;
    // Labelled points are lighter than predicted ones of the same class.
    vec3 own = id == 0 ? vec3(0.5) : predicted ? entry.rgb : mix(entry.rgb, vec3(1.0), 0.4);
    base = own * (unlabeled ? tone : tone + 0.15);
  }
  else if (mapping != 2 && id != 0 && id != 65344) {
    // The recording's light and shade stays under the label's colour, so that shapes stay legible.
    float light = dot(base, vec3(0.299, 0.587, 0.114));
    base = mix(base, entry.rgb * (0.55 + 0.6 * light), predicted ? 0.85 * labelBlend : labelBlend);
  }

  float grow = predicted && mapping != 1 ? 0.7 : 1.0;
  if (!deleted && (flags & 32) != 0) {
    base = mix(base, vec3(1.0), 0.65 * pulse);
    grow += 0.35 * pulse;
  }
  if (underBrush(position)) {
    bool spared = !deleted && (flags & 64) != 0 || brushOnlyUnlabeled != 0 && !unlabeled;
    if (!spared) {
      base = mix(base, brushColour, 0.62);
      grow *= 1.15;
    }
  }
  bool edged = id >= 65473 && id <= 65534 || id == 65344;
  shade = vec4(base, edged && outlining > 0.5 ? 0.5 : 1.0);

  gl_Position = projectionMatrix * (modelViewMatrix * vec4(position, 1.0));
#ifndef SURFACE
  float zoom = length(modelViewMatrix[0].xyz);
  pixels = pixelsPerMetre * projectionMatrix[1][1] * spacing * zoom / max(gl_Position.w, 1e-4);
  pixels = clamp(pixels, pixelLimits.x, pixelLimits.y) * grow;
  gl_PointSize = pixels;
#endif
}
`;

export const POINT_FRAGMENT = /* glsl */ `
precision highp float;
in vec4 shade;
flat in float pixels;
out vec4 result;

void main() {
  // Small points are square: a disc of three pixels has no round edge to show.
  if (pixels > 3.0) {
    vec2 d = gl_PointCoord * 2.0 - 1.0;
    if (dot(d, d) > 1.0) discard;
  }
  result = shade;
}
`;

/** Dots of one size in metres, with colours of their own: linear, and how opaque. */
export const DOT_VERTEX = /* glsl */ `
precision highp float;
in vec3 position;
in vec4 color;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
uniform vec4 settings[${SETTING_ROWS}];
#define halfHeight settings[6].z                // of the viewport, pixels
out vec4 shade;

void main() {
  vec3 dark = color.rgb * 12.92;
  vec3 light = 1.055 * pow(color.rgb, vec3(1.0 / 2.4)) - 0.055;
  shade = vec4(mix(dark, light, step(0.0031308, color.rgb)), color.a);
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
  float zoom = length(modelViewMatrix[0].xyz);
  gl_PointSize = SIZE * zoom * projectionMatrix[1][1] * halfHeight / max(gl_Position.w, 1e-4);
}
`;

/** Of dots and surfaces. */
export const PLAIN_FRAGMENT = /* glsl */ `
precision highp float;
in vec4 shade;
out vec4 result;
void main() {
  result = shade;
}
`;

export const SCREEN_VERTEX = /* glsl */ `
precision highp float;
in vec3 position;
out vec2 uv;
void main() {
  uv = position.xy * 0.5 + 0.5;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}
`;

/**
 * Darkens points behind their neighbours: shape without normals (Boucheny 2009).  Points of half
 * alpha, a click's candidate, have a white edge with a dark one around it, on any colour.
 */
export const EYE_DOME_FRAGMENT = /* glsl */ `
precision highp float;
precision highp sampler2D;
uniform sampler2D points;
uniform sampler2D depths;
uniform vec2 texel;
uniform vec3 clip;       // near, far; orthographic: weight of a metre, else 0
uniform vec2 shading;    // strength, 0: none; share of light that the darkest edge keeps
uniform float outline;   // pixels of the edge, 0: none
in vec2 uv;
out vec4 result;

float depthOf(float z) {
  if (clip.z > 0.0) return z * (clip.y - clip.x) * clip.z;
  return log2(clip.x * clip.y / (clip.y - z * (clip.y - clip.x)));
}

float logDistance(vec2 at) {
  float z = texture(depths, at).r;
  return z >= 1.0 ? -1.0 : depthOf(z);
}

float behind(float here, vec2 offset) {
  float there = logDistance(uv + offset * texel);
  // Beyond a silhouette there is nothing in front: no darkening towards the background.
  return there < -100.0 ? 0.0 : max(0.0, here - there);
}

// The depth of a place that is lit, else 2.
float litDepth(vec2 offset) {
  vec2 at = uv + offset * texel;
  return abs(texture(points, at).a - 0.5) < 0.2 ? texture(depths, at).r : 2.0;
}

// Lit places of the eight around, and the depth of the nearest.
vec2 litAround() {
  vec2 found = vec2(0.0, 2.0);
  for (int i = 0; i < 9; i++) {
    if (i == 4) continue;
    float z = litDepth(vec2(i % 3 - 1, i / 3 - 1) * outline);
    found = vec2(found.x + float(z < 2.0), min(found.y, z));
  }
  return found;
}

float shade(float z) {
  float here = depthOf(z);
  float sum = 0.0;
  sum += behind(here, vec2(1.4, 0.0)) + behind(here, vec2(-1.4, 0.0));
  sum += behind(here, vec2(0.0, 1.4)) + behind(here, vec2(0.0, -1.4));
  sum += behind(here, vec2(1.0, 1.0)) + behind(here, vec2(-1.0, -1.0));
  sum += behind(here, vec2(1.0, -1.0)) + behind(here, vec2(-1.0, 1.0));
  return max(shading.y, exp(-shading.x * sum / 8.0));
}

void main() {
  float z = texture(depths, uv).r;
  vec2 lit = outline > 0.0 ? litAround() : vec2(0.0, 2.0);
  bool within = litDepth(vec2(0.0)) < 2.0;
  bool edge = !within && lit.x > 0.0;
  if (z >= 1.0 && !edge) discard;
  vec3 colour = z < 1.0 ? texture(points, uv).rgb : vec3(0.0);
  if (z < 1.0 && shading.x > 0.0) colour *= shade(z);
  if (edge) colour = vec3(0.02, 0.03, 0.04);
  // Gaps between the points of an object are no edge of it.
  else if (within && lit.x < 5.5) colour = vec3(1.0);
  result = vec4(colour, 1.0);
  gl_FragDepth = edge ? min(z, lit.y) : z;
}
`;

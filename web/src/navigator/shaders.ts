/**
 * The light of docs/surfaces.md for the graphics card: src/gfx/lamp.h has the same formula in C. All of it is in eye
 * space. PLANES and LIGHTS are how many there are; SOLID is defined where a surface is only counted, not shown.
 */

const COMMON = `
precision highp float;
precision highp int;
uniform bool parallel_;
#if PLANES > 0
uniform vec4 planes[PLANES];
#endif
`;

const LIGHT = `
uniform int shading; // 0 none, 1 phong, 2 blinn
uniform vec4 gloss;  // ambient, diffuse, specular, shininess
uniform vec3 ambient;
#if LIGHTS > 0
uniform int kinds[LIGHTS]; // 0 directional, 1 point, 2 spot
uniform vec3 colors[LIGHTS], positions[LIGHTS], directions[LIGHTS], falloffs[LIGHTS];
uniform vec2 cones[LIGHTS];
#endif

float spot(vec2 cone, float c) {
  float t = clamp((c - cone.x) / max(cone.y - cone.x, 1e-6), 0.0, 1.0);
  return c <= cone.x ? 0.0 : t * t * (3.0 - 2.0 * t);
}

vec3 lit(vec3 color, vec3 place, vec3 n, vec3 eye) {
  if (shading == 0) return color;
  vec3 diffuse = vec3(0.0), highlight = vec3(0.0);
#if LIGHTS > 0
  for (int i = 0; i < LIGHTS; i++) {
    vec3 l = -directions[i];
    float share = 1.0;
    if (kinds[i] > 0) {
      l = positions[i] - place;
      float d = length(l);
      l = d > 0.0 ? l / d : vec3(0.0, 0.0, 1.0);
      share = 1.0 / (falloffs[i].x + d * (falloffs[i].y + d * falloffs[i].z));
      if (kinds[i] == 2) share *= spot(cones[i], -dot(l, directions[i]));
    }
    float nl = dot(n, l);
    if (nl <= 0.0) continue;
    vec3 h = l + eye;
    float s = shading == 1 ? dot(2.0 * nl * n - l, eye) : dot(n, h) / max(length(h), 1e-20);
    diffuse += share * nl * colors[i];
    if (s > 0.0) highlight += share * pow(s, gloss.w) * colors[i];
  }
#endif
  return color * (gloss.x * ambient + gloss.y * diffuse) + gloss.z * highlight;
}

float encoded(float v) {
  v = clamp(v, 0.0, 1.0);
  return v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1.0 / 2.4) - 0.055;
}

out vec4 pixel;
void show(vec3 light) {
  pixel = vec4(encoded(light.r), encoded(light.g), encoded(light.b), 1.0);
}
`;

/** Surfaces and meshes. */
export const surfaceVertex = `${COMMON}
in vec3 position;
in vec4 normal;
#ifdef COLORS
in vec4 color;
out vec3 own;
#endif
uniform mat4 map, clip; // from the file's numbers to eye space, and on
uniform mat3 turn;      // of normals
centroid out vec3 place, across; // beyond the rim of a triangle they would be anywhere
void main() {
#ifdef COLORS
  vec3 c = color.rgb;
  own = mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c));
#endif
  place = (map * vec4(position, 1.0)).xyz;
  across = turn * normal.xyz;
  float l = length(across);
  across = l > 0.0 ? across / l : vec3(0.0);
  gl_Position = clip * vec4(place, 1.0);
}
`;

export const surfaceFragment = `${COMMON}${LIGHT}
centroid in vec3 place, across;
#ifdef COLORS
in vec3 own;
#else
uniform vec3 own;
#endif
void main() {
#if PLANES > 0
  for (int i = 0; i < PLANES; i++)
    if (dot(planes[i].xyz, place) < planes[i].w) discard;
#endif
  vec3 eye = parallel_ ? vec3(0.0, 0.0, 1.0) : normalize(-place);
  float l = length(across);
  vec3 flat_ = cross(dFdx(place), dFdy(place));
  vec3 n = l > 1e-6 ? across / l : normalize(flat_);
  if (dot(n, eye) < 0.0) n = -n;
  show(lit(own, place, n, eye));
}
`;

/**
 * How often a ray goes through a closed surface after it has come through all planes that it has to come through: an
 * odd number says that it is inside there. Planes that it leaves by do not count: behind them it goes on.
 */
export const countFragment = `${COMMON}
centroid in vec3 place, across;
out vec4 pixel;
void main() {
  vec3 way = parallel_ ? vec3(0.0, 0.0, -1.0) : place;
#if PLANES > 0
  for (int i = 0; i < PLANES; i++)
    if (dot(planes[i].xyz, way) > 0.0 && dot(planes[i].xyz, place) < planes[i].w) discard;
#endif
  pixel = vec4(0.0);
}
`;

/** The face that is cut: where a ray comes through the last of the planes. It covers the whole picture. */
export const faceVertex = `${COMMON}
in vec3 position;
uniform vec2 half_;
out vec2 across;
void main() {
  across = position.xy * half_;
  gl_Position = vec4(position.xy, 0.0, 1.0);
}
`;

export const faceFragment = `${COMMON}${LIGHT}
in vec2 across;
uniform vec3 own;
uniform mat4 clip;
void main() {
  vec3 from = parallel_ ? vec3(across, 0.0) : vec3(0.0);
  vec3 way = parallel_ ? vec3(0.0, 0.0, -1.0) : vec3(across, -1.0);
  vec3 inwards = way;
  float begin = 0.0, end = 1e30;
#if PLANES > 0
  for (int i = 0; i < PLANES; i++) {
    float at = dot(planes[i].xyz, from) - planes[i].w, step_ = dot(planes[i].xyz, way);
    float t = -at / step_;
    if (step_ > 0.0 && t >= begin) {
      begin = t;
      inwards = planes[i].xyz;
    } else if (step_ < 0.0) {
      end = min(end, t);
    } else if (step_ == 0.0 && at < 0.0) {
      end = -1.0;
    }
  }
#endif
  vec3 place = from + begin * way;
  vec4 at = clip * vec4(place, 1.0);
  show(lit(own, place, -normalize(inwards), -normalize(way)));
  // Nearer than the nearest is on the first plane; what is empty goes behind everything, since a discarded one counts on.
  gl_FragDepth = begin < end ? (begin > 0.0 ? clamp(0.5 + 0.5 * at.z / at.w, 0.0, 0.99999) : 0.0) : 1.0;
}
`;

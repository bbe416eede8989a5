// SPDX-License-Identifier: BSD-3-Clause
// Shaders of cubes. A cube shows at most three faces to the camera: only these three are drawn. The work of
// a vertex counts: a map has a million of them.

export const cubeVertex = `
attribute vec4 place;      // centre and size, m
attribute float value;     // log-odds in steps of 1/16, shifted by 128
attribute vec3 face;       // axis of the face
uniform vec3 eye;          // camera in the frame of the map, m
uniform vec3 lightAbove;   // light of the upper faces of each axis of the map
uniform vec3 lightBelow;   // light of the lower faces
uniform vec4 up;           // height of a point: dot(up, point), m
uniform float least;       // least value
uniform vec2 heights;      // lowest and highest centre, m
uniform vec2 shade;        // brightness: shade.x + shade.y * height
uniform float grow;
varying vec2 at;
varying float light;
#ifdef BY_PROBABILITY
varying float p;
#endif
void main() {
  float height = dot(up, vec4(place.xyz, 1.0));
  if (value < least || height < heights.x || height > heights.y) {
    gl_Position = vec4(2.0, 2.0, 2.0, 1.0);
    return;
  }
#ifdef BY_PROBABILITY
  p = 1.0 / (1.0 + exp(-(value - 128.0) / 16.0));
#endif
  vec3 side = step(place.xyz, eye);
  light = dot(face, mix(lightBelow, lightAbove, side)) * (shade.x + shade.y * height);
  vec3 corner = position * mix(vec3(1.0), 2.0 * side - 1.0, face);
  at = vec2(dot(position, face.yzx), dot(position, face.zxy));
  gl_Position = projectionMatrix * (modelViewMatrix * vec4(place.xyz + corner * (place.w * grow), 1.0));
}`;

export const cubeFragment = `
uniform vec3 colour;
uniform vec3 paper;
uniform float dim;           // share of the paper in the colour
varying vec2 at;
varying float light;
#ifdef BY_PROBABILITY
uniform vec3 ramp[9];
varying float p;
#endif
void main() {
#ifdef GHOST
  // Every other pixel stays open.
  if (mod(floor(gl_FragCoord.x * 0.5) + floor(gl_FragCoord.y * 0.5), 2.0) < 0.5) discard;
#endif
  vec3 base = colour;
#ifdef BY_PROBABILITY
  float s = clamp((p - 0.5) * 2.0, 0.0, 1.0) * 7.999;
  int i = int(s);
  base = mix(ramp[i], ramp[i + 1], fract(s));
#endif
  vec2 d = 0.5 - abs(at);
  float wide = fwidth(at.x) + fwidth(at.y);
  float border = (1.0 - smoothstep(0.0, 1.5 * wide, min(d.x, d.y))) * (1.0 - smoothstep(0.06, 0.2, wide));
  gl_FragColor = vec4(mix(base * (light * (1.0 - 0.28 * border)), paper, dim), 1.0);
}`;

// Faces of free space towards the unknown.
export const faceVertex = `
attribute vec3 corner;
uniform vec2 heights;
void main() {
  vec4 world = modelMatrix * vec4(corner, 1.0);
  bool shown = world.z >= heights.x && world.z <= heights.y;
  gl_Position = shown ? projectionMatrix * viewMatrix * world : vec4(2.0, 2.0, 2.0, 1.0);
}`;
export const faceFragment = `
uniform vec3 colour;
void main() { gl_FragColor = vec4(colour, 0.16); }`;

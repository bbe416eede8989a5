// SPDX-License-Identifier: BSD-3-Clause
// Shaders of cubes. A cube shows at most three faces to the camera: only these three are drawn.

export const cubeVertex = `
attribute vec4 place;      // centre and size, m
attribute float value;     // log-odds in steps of 1/16, shifted by 128
attribute vec3 face;       // axis of the face
uniform vec3 eye;          // camera in the frame of the map, m
uniform float least;       // least probability
uniform vec2 heights;      // lowest and highest centre, m
uniform vec2 extent;       // lowest and highest point of the scene, m
uniform float grow;
varying vec2 at;
varying float light;
varying float p;
void main() {
  p = 1.0 / (1.0 + exp(-(value - 128.0) / 16.0));
  vec3 side = mix(vec3(1.0), sign(eye - place.xyz), face);
  vec4 centre = modelMatrix * vec4(place.xyz, 1.0);
  vec4 world = modelMatrix * vec4(place.xyz + position * side * place.w * grow, 1.0);
  vec3 normal = mat3(modelMatrix) * (face * side);
  float height = clamp((centre.z - extent.x) / max(extent.y - extent.x, 0.01), 0.0, 1.0);
  light = (0.66 + 0.34 * max(0.0, dot(normal, normalize(vec3(-0.35, -0.55, 1.0))))) *
          (0.86 + 0.2 * height);
  at = face.x > 0.5 ? position.yz : face.y > 0.5 ? position.xz : position.xy;
  bool shown = p >= least && centre.z >= heights.x && centre.z <= heights.y;
  gl_Position = shown ? projectionMatrix * viewMatrix * world : vec4(2.0, 2.0, 2.0, 1.0);
}`;

export const cubeFragment = `
uniform vec3 colour;
uniform vec3 ramp[9];
uniform float byProbability; // 1: the colour shows the probability
uniform vec3 paper;
uniform float dim;           // share of the paper in the colour
uniform float ghost;         // 1: every other pixel stays open
varying vec2 at;
varying float light;
varying float p;
void main() {
  if (ghost > 0.5 && mod(floor(gl_FragCoord.x * 0.5) + floor(gl_FragCoord.y * 0.5), 2.0) < 0.5) discard;
  vec3 base = colour;
  if (byProbability > 0.5) {
    float s = clamp((p - 0.5) * 2.0, 0.0, 1.0) * 7.999;
    int i = int(s);
    base = mix(ramp[i], ramp[i + 1], fract(s));
  }
  vec2 d = 0.5 - abs(at);
  float wide = fwidth(at.x) + fwidth(at.y);
  float border = (1.0 - smoothstep(0.0, 1.5 * wide, min(d.x, d.y))) * (1.0 - smoothstep(0.06, 0.2, wide));
  vec3 c = base * light * (1.0 - 0.28 * border);
  gl_FragColor = vec4(mix(c, paper, dim), 1.0);
}`;

// Faces of free space towards the unknown. The value of a cube is a mask of its 6 faces.
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

// SPDX-License-Identifier: BSD-3-Clause
// Makes the objects of the picture from the scene: cubes, faces of free space, lines, ellipsoids.
import {
  Box3, BufferAttribute, BufferGeometry, Color, DoubleSide, Group, InstancedBufferAttribute,
  InstancedBufferGeometry, LineBasicMaterial, LineSegments, Matrix4, Mesh, MeshBasicMaterial, ShaderMaterial,
  Sphere, SphereGeometry, Vector3, Vector4,
} from 'three';
import {bytesOf, centreOf, unpackCubes, wordsOf} from './data.js';
import {cubeFragment, cubeVertex, faceFragment, faceVertex} from './shaders.js';

/** Returns the matrix of a pose: 12 numbers, the first 3 rows of a 4x4 matrix. */
export function matrixOf(pose) {
  const m = new Matrix4();
  if (pose) m.set(...pose, 0, 0, 0, 1);
  return m;
}

function groupAt(pose) {
  const group = new Group();
  group.matrixAutoUpdate = false;
  group.matrix.copy(matrixOf(pose));
  group.matrixWorldNeedsUpdate = true;
  return group;
}

/** Three faces of a cube of side 1; the shader turns them towards the camera. */
function threeFaces() {
  const position = [], face = [], index = [];
  for (let axis = 0; axis < 3; axis++) {
    for (let i = 0; i < 4; i++) {
      const p = [0, 0, 0], n = [0, 0, 0];
      p[axis] = 0.5;
      p[(axis + 1) % 3] = i & 1 ? 0.5 : -0.5;
      p[(axis + 2) % 3] = i & 2 ? 0.5 : -0.5;
      n[axis] = 1;
      position.push(...p);
      face.push(...n);
    }
    const k = 4 * axis;
    index.push(k, k + 1, k + 2, k + 2, k + 1, k + 3);
  }
  return {position: new BufferAttribute(new Float32Array(position), 3),
    face: new BufferAttribute(new Float32Array(face), 3), index: new BufferAttribute(new Uint16Array(index), 1)};
}

const kFaces = threeFaces();
const kCubesOfChunk = 6000;

/** The cubes of a map at several levels of detail, each unpacked when it is first needed. Several objects may
 * share them. */
export class CubeSet {
  static kLevels = 4;

  constructor(packed) {
    this.packed = packed;
    this.resolution = packed.resolution;
    this.unpacked = [];
    this.chunked = [];
  }

  /** Returns the cubes of a level: cubes of less than 2^level voxels are joined. */
  cubes(level) {
    return (this.unpacked[level] ??= unpackCubes(this.packed, 1 << level));
  }

  /** Returns a level as geometries. The cubes of a chunk lie together, so that chunks outside of the picture are
   * not drawn. */
  chunks(level) {
    return (this.chunked[level] ??= this.split(this.cubes(level)));
  }

  split({count, place, value}) {
    const chunks = [], box = new Box3(), p = new Vector3();
    for (let from = 0; from < count; from += kCubesOfChunk) {
      const to = Math.min(from + kCubesOfChunk, count);
      const geometry = new InstancedBufferGeometry();
      geometry.setAttribute('position', kFaces.position);
      geometry.setAttribute('face', kFaces.face);
      geometry.setIndex(kFaces.index);
      geometry.setAttribute('place', new InstancedBufferAttribute(place.subarray(4 * from, 4 * to), 4));
      geometry.setAttribute('value', new InstancedBufferAttribute(value.subarray(from, to), 1));
      geometry.instanceCount = to - from;
      box.makeEmpty();
      let largest = 0;
      for (let i = 4 * from; i < 4 * to; i += 4) {
        box.expandByPoint(p.set(place[i], place[i + 1], place[i + 2]));
        largest = Math.max(largest, place[i + 3]);
      }
      geometry.boundingSphere = box.getBoundingSphere(new Sphere());
      geometry.boundingSphere.radius += 1.2 * largest;
      chunks.push(geometry);
    }
    return chunks;
  }
}

const kLight = new Vector3(-0.35, -0.55, 1).normalize();

/** Cubes at a pose. `shared`: uniforms that all cubes have in common. */
export function cubes(set, pose, shared, {byProbability = false, ghost = false, grow = 1} = {}) {
  const uniforms = {...shared, eye: {value: new Vector3()}, lightAbove: {value: new Vector3()},
    lightBelow: {value: new Vector3()}, up: {value: new Vector4()}, colour: {value: new Color()}, dim: {value: 0},
    grow: {value: grow}};
  const defines = {...(byProbability && {BY_PROBABILITY: ''}), ...(ghost && {GHOST: ''})};
  const material = new ShaderMaterial({vertexShader: cubeVertex, fragmentShader: cubeFragment, side: DoubleSide, uniforms, defines});
  const group = groupAt(pose);
  const inverse = new Matrix4();
  let shown = null;
  /** Chooses the level for a scale (pixels per metre; `least` pixels for a cube) and a camera. */
  group.prepare = (camera, scale, least) => {
    let level = 0;
    while (level + 1 < CubeSet.kLevels && set.resolution * (1 << level) * scale < least) level++;
    if (level !== shown) {
      group.clear();
      for (const geometry of set.chunks(level)) group.add(new Mesh(geometry, material));
      shown = level;
    }
    const e = group.matrix.elements;
    uniforms.eye.value.copy(camera.position).applyMatrix4(inverse.copy(group.matrix).invert());
    uniforms.up.value.set(e[2], e[6], e[10], e[14]);
    for (let axis = 0; axis < 3; axis++) {
      const facing = e[4 * axis] * kLight.x + e[4 * axis + 1] * kLight.y + e[4 * axis + 2] * kLight.z;
      uniforms.lightAbove.value.setComponent(axis, 0.66 + 0.34 * Math.max(0, facing));
      uniforms.lightBelow.value.setComponent(axis, 0.66 + 0.34 * Math.max(0, -facing));
    }
  };
  group.paint = (hex, dim = 0) => {
    uniforms.colour.value.set(hex);
    uniforms.dim.value = dim;
  };
  return group;
}

/** The faces where free space ends at unknown space. */
export function freeFaces(packed, pose, shared) {
  const {count, place, value} = unpackCubes(packed);
  let faces = 0;
  for (let i = 0; i < count; i++) for (let b = 0; b < 6; b++) faces += (value[i] >> b) & 1;
  const corner = new Float32Array(12 * faces);
  const index = new Uint32Array(6 * faces);
  let f = 0;
  for (let i = 0; i < count; i++)
    for (let b = 0; b < 6; b++) {
      if (!((value[i] >> b) & 1)) continue;
      const axis = b >> 1, half = place[4 * i + 3] / 2;
      for (let c = 0; c < 4; c++) {
        const d = [0, 0, 0];
        d[axis] = b & 1 ? half : -half;
        d[(axis + 1) % 3] = c & 1 ? half : -half;
        d[(axis + 2) % 3] = c & 2 ? half : -half;
        for (let k = 0; k < 3; k++) corner[12 * f + 3 * c + k] = place[4 * i + k] + d[k];
      }
      const v = 4 * f;
      index.set([v, v + 1, v + 2, v + 2, v + 1, v + 3], 6 * f);
      f++;
    }
  const geometry = new BufferGeometry();
  geometry.setAttribute('corner', new BufferAttribute(corner, 3));
  geometry.setIndex(new BufferAttribute(index, 1));
  const material = new ShaderMaterial({vertexShader: faceVertex, fragmentShader: faceFragment, side: DoubleSide,
    transparent: true, depthWrite: false, uniforms: {...shared, colour: {value: new Color()}}});
  const mesh = new Mesh(geometry, material);
  mesh.frustumCulled = false;
  const group = groupAt(pose);
  group.add(mesh);
  group.paint = (hex) => material.uniforms.colour.value.set(hex);
  return group;
}

export function lines(points, pose) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(points), 3));
  const material = new LineBasicMaterial({toneMapped: false});
  const object = new LineSegments(geometry, material);
  object.frustumCulled = false;
  const group = groupAt(pose);
  group.add(object);
  group.paint = (hex) => material.color.set(hex);
  group.material = material;
  return group;
}
/** Structural edges: a short line along the direction of each edge voxel. */
export function edgeLines(edges, pose) {
  const keys = wordsOf(edges.keys);
  const directions = new Int8Array(bytesOf(edges.directions).buffer);
  const r = edges.resolution, half = Math.max(1.5 * r, 0.12);
  const points = [];
  for (let i = 0; i < keys.length; i += 3)
    for (const side of [-1, 1])
      for (let k = 0; k < 3; k++) points.push(centreOf(keys[i + k], r) + (side * half * directions[i + k]) / 127);
  return lines(points, pose);
}

/** Matched pairs: lines from voxels of A to voxels of B. */
export function pairLines(list, resolutionA, resolutionB, poseB) {
  const words = wordsOf(list);
  const m = matrixOf(poseB), b = new Vector3();
  const points = [];
  for (let i = 0; i < words.length; i += 6) {
    for (let k = 0; k < 3; k++) points.push(centreOf(words[i + k], resolutionA));
    b.set(...[3, 4, 5].map((k) => centreOf(words[i + k], resolutionB))).applyMatrix4(m);
    points.push(b.x, b.y, b.z);
  }
  return lines(points, null);
}

/** An ellipsoid: its half-axes are the columns of `axes` (9 numbers, by rows), m. */
export function ellipsoid(at, axes) {
  const material = new MeshBasicMaterial({transparent: true, opacity: 0.55, depthWrite: false});
  const mesh = new Mesh(new SphereGeometry(1, 24, 16), material);
  mesh.matrixAutoUpdate = false;
  const [a, b, c, d, e, f, g, h, i] = axes;
  mesh.matrix.set(a, b, c, at[0], d, e, f, at[1], g, h, i, at[2], 0, 0, 0, 1);
  mesh.renderOrder = 2;
  mesh.paint = (hex) => material.color.set(hex);
  return mesh;
}

/** A tube between two points, as thick as `radius`, m; dashed if `parts` > 1. */
export function tube(from, to, radius, parts) {
  const a = new Vector3(...from), b = new Vector3(...to);
  const group = new Group();
  const material = new MeshBasicMaterial();
  const length = a.distanceTo(b);
  const x = b.clone().sub(a).normalize();
  const y = new Vector3(0, 0, 1).cross(x);
  if (y.lengthSq() < 1e-9) y.set(0, 1, 0);
  y.normalize();
  const z = x.clone().cross(y);
  for (let i = 0; i < parts; i++) {
    const half = (length / parts / 2) * (parts > 1 ? 0.6 : 1);
    const mid = a.clone().lerp(b, (i + 0.5) / parts);
    const mesh = new Mesh(tubeGeometry, material);
    mesh.matrixAutoUpdate = false;
    mesh.matrix.makeBasis(x.clone().multiplyScalar(half), y.clone().multiplyScalar(radius), z.clone().multiplyScalar(radius));
    mesh.matrix.setPosition(mid);
    group.add(mesh);
  }
  group.paint = (hex) => material.color.set(hex);
  return group;
}

// A prism with 8 sides along x, from -1 to 1.
const tubeGeometry = (() => {
  const position = [], index = [];
  for (let i = 0; i < 8; i++) {
    const angle = (i * Math.PI) / 4;
    position.push(-1, Math.cos(angle), Math.sin(angle), 1, Math.cos(angle), Math.sin(angle));
    const k = 2 * i, n = (2 * i + 2) % 16;
    index.push(k, k + 1, n, n, k + 1, n + 1);
  }
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(new Float32Array(position), 3));
  geometry.setIndex(index);
  return geometry;
})();

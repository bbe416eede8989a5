// SPDX-License-Identifier: BSD-3-Clause
// Reads the two blocks of data of the page: the report, as --json writes it, and the scene.

/** Returns the JSON of a block of data. */
export function readBlock(id) {
  return JSON.parse(document.getElementById(id).textContent);
}

/** Returns the bytes of a base64 text. */
export function bytesOf(base64) {
  const text = atob(base64 || '');
  const bytes = new Uint8Array(text.length);
  for (let i = 0; i < bytes.length; i++) bytes[i] = text.charCodeAt(i);
  return bytes;
}

/** Returns numbers of 16 bits, little endian, of a base64 text. */
export function wordsOf(base64) {
  const bytes = bytesOf(base64);
  const words = new Uint16Array(bytes.length >> 1);
  for (let i = 0; i < words.length; i++) words[i] = bytes[2 * i] | (bytes[2 * i + 1] << 8);
  return words;
}

const kDepth = 16; // depth of the finest voxels
const kHalf = 1 << (kDepth - 1);

/** Returns the coordinate of the centre of a finest voxel, m. */
export const centreOf = (key, resolution) => (key - kHalf + 0.5) * resolution;

/**
 * Unpacks cubes. The tree is written node by node, depth first: 2 bits for each of 8 children
 * (0: nothing, 1: a cube, 2: a node). Each cube has one byte in `values`.
 * `least`: side of the smallest cubes, finest voxels. Smaller cubes become one, with their highest value.
 * Returns {count, place: Float32Array (centre and size of each cube, m), value: Uint8Array}.
 */
export function unpackCubes(packed, least = 1) {
  const tree = bytesOf(packed.tree);
  const values = bytesOf(packed.values);
  const place = new Float32Array(4 * values.length);
  const value = new Uint8Array(values.length);
  const r = packed.resolution;
  let [read, used, count] = [0, 0, 0];
  const highestBelow = () => {
    const mask = tree[read] | (tree[read + 1] << 8);
    read += 2;
    let highest = 0;
    for (let i = 0; i < 16; i += 2) {
      const kind = (mask >> i) & 3;
      if (kind !== 0) highest = Math.max(highest, kind === 2 ? highestBelow() : values[used++]);
    }
    return highest;
  };
  const node = (x, y, z, side) => {
    const mask = tree[read] | (tree[read + 1] << 8);
    read += 2;
    const half = side / 2;
    for (let i = 0; i < 8; i++) {
      const kind = (mask >> (2 * i)) & 3;
      if (kind === 0) continue;
      const cx = x + (i & 1 ? half : 0);
      const cy = y + (i & 2 ? half : 0);
      const cz = z + (i & 4 ? half : 0);
      if (kind === 2 && half > least) {
        node(cx, cy, cz, half);
        continue;
      }
      value[count] = kind === 2 ? highestBelow() : values[used++];
      place[4 * count] = (cx + half / 2 - kHalf) * r;
      place[4 * count + 1] = (cy + half / 2 - kHalf) * r;
      place[4 * count + 2] = (cz + half / 2 - kHalf) * r;
      place[4 * count + 3] = half * r;
      count++;
    }
  };
  if (tree.length > 0) node(0, 0, 0, 1 << kDepth);
  return {count, place: place.subarray(0, 4 * count), value: value.subarray(0, count)};
}

/** Returns the probability of a value: log-odds in steps of 1/16, shifted by 128. */
export const probabilityOf = (value) => 1 / (1 + Math.exp(-(value - 128) / 16));

/** Returns the value of a probability, see probabilityOf(). */
export const valueOfProbability = (p) => 128 + 16 * Math.log(p / (1 - p));

/** Returns a text from outside with control characters, and characters that turn the direction of
 * text around, made visible. */
export function printable(text) {
  return String(text).replace(/[\u0000-\u001f\u007f-\u009f\u200b-\u200f\u2028-\u202e\u2060-\u2069\ufeff]/g,
    (c) => '\\u' + c.charCodeAt(0).toString(16).padStart(4, '0'));
}

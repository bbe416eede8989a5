// SPDX-License-Identifier: BSD-3-Clause
// Colours of the picture. They are those of Okabe and Ito, which colour-blind people can tell apart.

const kThemes = {
  light: {
    background: '#eef1f4', grid: '#a9b3bf', ink: '#1b2430', inlier: '#1b2430', outlier: '#c8102e', conflict: '#c8102e',
    free: '#009e73', edge: ['#8a4b00', '#003a6b'],
    links: {sure: '#009e73', held: '#0072b2', refuted: '#c8102e', rejected: '#a9b3bf', edges: '#6b7480'},
    maps: ['#e69f00', '#0072b2', '#009e73', '#cc79a7', '#56b4e9', '#d55e00', '#d9cb1f', '#6b7480'],
  },
  dark: {
    background: '#10141a', grid: '#4b5663', ink: '#e8ecf1', inlier: '#e8ecf1', outlier: '#ff5a6e', conflict: '#ff3d57',
    free: '#2fd0a0', edge: ['#ffe2a8', '#cfeaff'],
    links: {sure: '#2fd0a0', held: '#56b4e9', refuted: '#ff3d57', rejected: '#4b5663', edges: '#b8c0ca'},
    maps: ['#e69f00', '#56b4e9', '#19b98a', '#cc79a7', '#f0e442', '#e8743a', '#4a90d9', '#b8c0ca'],
  },
};

/** Returns the colours of 'light' or 'dark'. */
export const themeOf = (name) => kThemes[name];

export function rgbOf(hex) {
  const n = parseInt(hex.slice(1), 16);
  return [(n >> 16) / 255, ((n >> 8) & 255) / 255, (n & 255) / 255];
}

/** Returns the colour of a map by its number. Maps after the first 8 have paler colours. */
export function mapColour(theme, i) {
  const hex = theme.maps[i % theme.maps.length];
  const pale = Math.min(0.6, 0.3 * Math.floor(i / theme.maps.length));
  if (pale === 0) return hex;
  const mixed = rgbOf(hex).map((c) => Math.round(255 * (c + (1 - c) * pale)));
  return '#' + mixed.map((c) => c.toString(16).padStart(2, '0')).join('');
}

// Viridis in 9 steps: from purple to yellow, of growing lightness.
const kViridis = ['#440154', '#472d7b', '#3b528b', '#2c728e', '#21918c', '#28ae80', '#5ec962', '#addc30', '#fde725'];

/** Colour of a probability from 0.5 to 1 for a theme: certain voxels stand out. */
export function rampOf(themeName) {
  return themeName === 'dark' ? kViridis : [...kViridis].reverse();
}

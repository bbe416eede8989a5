// SPDX-License-Identifier: BSD-3-Clause
// The page of a run of map-fusion: fills the words, then the picture.
import {readBlock} from './data.js';
import {fillPanel} from './panel.js';
import {Picture} from './picture.js';
import {el} from './words.js';

const report = readBlock('report');
const scene = readBlock('scene');

let picture = null;
let why = '';
try {
  picture = new Picture(document.getElementById('stage'), scene);
} catch (e) {
  why = e.message;
}
if (!picture) {
  document.getElementById('stage').replaceChildren(el('p', {class: 'missing'}, 'This browser cannot draw in 3-D (WebGL): ' + why));
}
fillPanel(document.getElementById('panel'), report, scene, {
  show: picture ? (i) => picture.showRival(i) : null,
  swatch: (map) => el('i', {class: 'swatch', 'data-map': map ? map.colour : ''}),
});
if (picture) picture.start();
// Times since the page was opened, ms: when all is made, and when the first frame is on the screen.
const {dataset} = document.documentElement;
dataset.ready = Math.round(performance.now());
requestAnimationFrame(() => requestAnimationFrame(() => { dataset.shown = Math.round(performance.now()); }));

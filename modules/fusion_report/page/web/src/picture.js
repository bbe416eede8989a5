// SPDX-License-Identifier: BSD-3-Clause
// The picture: its layers, the switches and sliders, the legend.
import {Box3, Color, Group, Vector3} from 'three';
import {mapColour, rampOf, themeOf} from './colours.js';
import {probabilityOf, valueOfProbability} from './data.js';
import {CubeSet, cubes, edgeLines, ellipsoid, freeFaces, lines, matrixOf, pairLines, tube} from './layers.js';
import {View} from './view.js';
import {el, said} from './words.js';

const kDim = {light: 0.72, dark: 0.6}; // share of the paper in the colour of pale maps
// Links of a team: verdict, words, number of dashes, width.
const kLinks = [['sure', 'match is sure and holds', 1, 1], ['held', 'holds, not sure alone', 9, 0.8],
  ['refuted', 'sure alone, does not hold', 5, 0.8], ['rejected', 'rejected', 1, 0], ['edges', 'placed by edges', 15, 0.8]];
const kPointsOfMap = 1500; // points of a map that the view shows for sure

export class Picture {
  constructor(stage, scene) {
    this.stage = stage;
    this.data = scene;
    this.layers = [];
    this.labels = [];
    this.canvas = el('canvas', {tabindex: 0, role: 'img', 'aria-label': 'Picture of the maps in 3-D. Arrow keys turn it.'});
    this.overlay = el('div', {class: 'labels', 'aria-hidden': 'true'});
    stage.append(this.canvas, this.overlay);
    this.view = new View(this.canvas);
    this.heights = {value: null};
    this.shared = {least: {value: 0}, heights: {value: [-1e9, 1e9]}, shade: {value: [1, 0]},
      ramp: {value: Array.from({length: 9}, () => new Color())}, paper: {value: new Color()}};
    this.night = matchMedia('(prefers-color-scheme: dark)');
    this.build();
  }

  /** Adds a layer. `paint(theme, name)` colours it; `swatch(theme)` is the colour of its legend. */
  layer(key, name, object, {on = true, paint, swatch, count = null, kind = 'square', hint = null, links = []}) {
    object.visible = on;
    this.view.scene.add(object);
    const layer = {key, name, object, on, paint, swatch, count, kind, hint, links};
    this.layers.push(layer);
    return layer;
  }

  build() {
    const {data, shared} = this;
    const box = new Box3();
    this.points = [];
    const histogram = new Map();
    const colour = (theme, m) => mapColour(theme, m.colour);
    const conflicts = new Group(), edges = new Group();
    let conflictCount = 0, edgeCount = 0;
    this.maps = data.maps.map((m) => {
      const geometry = new CubeSet(m.occupied);
      const object = cubes(geometry, m.pose, shared);
      const layer = this.layer('map-' + m.colour, data.kind === 'pair' ? 'Map ' + m.name : m.name, object, {
        on: m.shown, paint: (theme) => object.paint(colour(theme, m), this.dim ? kDim[this.themeName] : 0), swatch: (theme) => colour(theme, m), count: m.count});
      if (m.shown) this.measure(geometry, m.pose, box, histogram);
      return {m, geometry, object, layer};
    });
    if (data.fused) {
      const geometry = new CubeSet(data.fused.occupied);
      const object = cubes(geometry, null, shared, {byProbability: true});
      this.layer('fused', 'Fused map', object, {on: false, paint: (theme, name) => object.paint('#fff', 0),
        swatch: (theme, name) => `linear-gradient(90deg, ${rampOf(name).join(',')})`, count: data.fused.count, kind: 'ramp'});
      if (box.isEmpty()) this.measure(geometry, null, box, histogram);
    }
    for (const {m} of this.maps) {
      if (m.conflicts) {
        const object = cubes(new CubeSet(m.conflicts), m.pose, {...shared, least: {value: 0}}, {grow: 1.35});
        conflicts.add(object);
        conflictCount += m.conflicts.count;
      }
      if (m.edges) {
        const object = edgeLines(m.edges, m.pose);
        object.map = m;
        edges.add(object);
        edgeCount += m.edges.count;
      }
    }
    if (data.maps.some((m) => m.conflicts))
      this.layer('conflicts', 'Conflicts', conflicts, {paint: (theme) => conflicts.children.forEach((c) => c.paint(theme.conflict)),
        swatch: (theme) => theme.conflict, count: conflictCount});
    const free = new Group();
    for (const m of [...data.maps, ...(data.fused ? [data.fused] : [])]) if (m.free) free.add(freeFaces(m.free, m.pose, shared));
    if (free.children.length > 0)
      this.layer('free', 'Boundary of free space', free, {on: false, paint: (theme) => free.children.forEach((c) => c.paint(theme.free)), swatch: (theme) => theme.free});
    if (edgeCount > 0)
      this.layer('edges', 'Structural edges', edges, {on: false, kind: 'line', count: edgeCount,
        paint: (theme) => edges.children.forEach((c) => c.paint(data.kind === 'pair' ? theme.edge[c.map.colour % 2] : theme.ink)), swatch: (theme) => theme.edge[0]});
    if (data.pairs) this.addPairs();
    if (data.rivals?.length) this.addGhost();
    if (data.graph?.nodes.length) this.addGraph();
    if (box.isEmpty()) box.set(new Vector3(-1, -1, -1), new Vector3(1, 1, 1));
    this.box = box;
    this.histogram = histogram;
    this.addGrid(box);
  }

  /** Extends a box, a histogram of heights and the points of the view by cubes. */
  measure(set, pose, box, histogram) {
    const {place} = set.cubes(1), m = matrixOf(pose), p = new Vector3();
    const stride = 4 * Math.ceil(place.length / 4 / kPointsOfMap);
    for (let i = 0; i < place.length; i += 4) {
      p.set(place[i], place[i + 1], place[i + 2]).applyMatrix4(m);
      box.expandByPoint(p);
      if (i % stride === 0) this.points.push(p.clone());
      const h = Math.round(p.z * 10);
      histogram.set(h, (histogram.get(h) ?? 0) + place[i + 3] * place[i + 3]);
    }
  }

  addPairs() {
    const {pairs, maps} = this.data;
    const group = new Group(), r = [maps[0].occupied.resolution, maps[1].occupied.resolution];
    const near = pairLines(pairs.inliers, ...r, maps[1].pose), far = pairLines(pairs.outliers, ...r, maps[1].pose);
    group.add(near, far);
    this.layer('pairs', 'Matched pairs', group, {on: false, kind: 'line', count: pairs.count,
      paint: (theme) => { near.paint(theme.inlier); far.paint(theme.outlier); }, swatch: (theme) => theme.inlier});
  }

  addGhost() {
    const group = new Group();
    this.ghosts = this.maps.map(({geometry, m}) => {
      const object = cubes(geometry, null, this.shared, {ghost: true});
      object.visible = false;
      group.add(object);
      return object;
    });
    this.ghostLayer = this.layer('ghost', 'Rival pose', group, {on: false,
      paint: (theme) => this.ghosts.forEach((g, i) => g.paint(mapColour(theme, this.data.maps[i].colour), 0.15)), swatch: null});
    this.rival = 0;
  }

  addGraph() {
    const {maps} = this.data, {nodes, links, enlarged} = this.data.graph;
    const group = new Group(), size = this.graphSize();
    const at = (i) => nodes.find((n) => n.map === i)?.at;
    const kinds = kLinks.filter(([k]) => links.some((l) => l.verdict === k));
    const tubes = links.map((l) => {
      if (!at(l.a) || !at(l.b)) return null;
      const [, , parts, width] = kLinks.find(([k]) => k === l.verdict);
      const t = width > 0 ? tube(at(l.a), at(l.b), width * size, parts) : lines([...at(l.a), ...at(l.b)], null);
      t.verdict = l.verdict;
      group.add(t);
      return t;
    }).filter(Boolean);
    const balls = nodes.map((n) => {
      const ball = ellipsoid(n.at, [2.4 * size, 0, 0, 0, 2.4 * size, 0, 0, 0, 2.4 * size]);
      ball.material.opacity = 1;
      ball.material.depthWrite = true;
      ball.map = n.map;
      group.add(ball);
      if (n.axes) {
        const e = ellipsoid(n.at, n.axes);
        e.map = n.map;
        group.add(e);
        return [ball, e];
      }
      return [ball];
    }).flat();
    const name = this.data.kind === 'team' ? 'Graph of the team' : 'Uncertainty of B';
    const hint = nodes.some((n) => n.axes) ? `Ellipsoids: 3 standard deviations${enlarged > 1 ? `, drawn ${enlarged} times as large` : ''}` : null;
    const layer = this.layer('graph', name, group, {kind: 'line', hint, links: kinds, on: this.data.kind === 'team', paint: (theme) => {
      tubes.forEach((t) => t.paint(theme.links[t.verdict]));
      balls.forEach((b) => b.paint(mapColour(theme, maps[b.map].colour)));
    }, swatch: (theme) => theme.links.sure});
    this.labels = nodes.map((n) => {
      const label = el('span', {class: 'label'}, said(maps[n.map].name));
      this.overlay.append(label);
      return {label, at: new Vector3(...n.at), layer};
    });
  }

  graphSize() {
    const all = this.data.graph.nodes.map((n) => new Vector3(...n.at));
    const box = new Box3().setFromPoints(all);
    return Math.max(0.06, 0.004 * box.getSize(new Vector3()).length());
  }

  addGrid(box) {
    const size = box.getSize(new Vector3());
    const longest = Math.max(size.x, size.y, 0.01);
    let step = 10 ** Math.floor(Math.log10(longest / 4));
    for (const k of [5, 2]) if (longest / (k * step) > 4) { step *= k; break; }
    this.step = step;
    const points = [], z = box.min.z - 0.02 * Math.max(size.z, 0.1);
    const from = (v) => (Math.floor(v / step) - 1) * step, to = (v) => (Math.ceil(v / step) + 1) * step;
    const [x0, x1, y0, y1] = [from(box.min.x), to(box.max.x), from(box.min.y), to(box.max.y)];
    for (let x = x0; x <= x1 + step / 2; x += step) points.push(x, y0, z, x, y1, z);
    for (let y = y0; y <= y1 + step / 2; y += step) points.push(x0, y, z, x1, y, z);
    this.grid = lines(points, null);
    this.view.scene.add(this.grid);
  }

  /** Returns the height at which the ceiling is cut off, or null. A ceiling is the largest flat layer above
   * the middle of the heights. */
  ceiling() {
    const {min, max} = this.box;
    if (max.z - min.z < 1.5) return null;
    const area = (h) => [-2, -1, 0, 1, 2].reduce((sum, k) => sum + (this.histogram.get(h + k) ?? 0), 0);
    const total = [...this.histogram.values()].reduce((sum, n) => sum + n, 0);
    let best = null;
    for (const h of this.histogram.keys())
      if (h > 5 * (min.z + max.z) && (!best || area(h) > area(best))) best = h;
    return best !== null && area(best) > 0.12 * total ? best / 10 - 0.3 : null;
  }

  /** Builds the switches and draws the first frame. */
  start() {
    const {min, max} = this.box;
    this.view.box = this.box;
    if (this.points.length > 0) this.view.points = this.points;
    const rise = 0.2 / Math.max(max.z - min.z, 0.01);
    this.shared.shade.value = [0.86 - rise * min.z, rise];
    this.buildControls();
    this.view.after.push(() => this.placeLabels());
    this.applyTheme();
    this.night.addEventListener('change', () => this.applyTheme());
    addEventListener('beforeprint', () => this.print());
    addEventListener('afterprint', () => this.applyTheme());
    this.view.marginOf = (width) => (width > 700 ? 264 : 0);
    this.view.applyMargin();
    this.view.look();
    this.view.drawNow(!this.view.inSoftware);
    if (this.view.inSoftware) this.view.refine();
  }

  applyTheme(forced) {
    const name = forced ?? (this.night.matches ? 'dark' : 'light');
    const theme = themeOf(name);
    this.themeName = name;
    this.shared.paper.value.set(theme.background);
    rampOf(name).forEach((c, i) => this.shared.ramp.value[i].set(c));
    this.view.renderer.setClearColor(new Color(theme.background), 1);
    this.grid.paint(theme.grid);
    for (const l of this.layers) l.paint(theme, name);
    for (const l of this.layers) if (l.mark && l.swatch) l.mark.style.background = l.swatch(theme, name);
    for (const i of this.stage.querySelectorAll('i[data-link]')) i.style.color = theme.links[i.dataset.link];
    for (const i of document.querySelectorAll('i.swatch[data-map]')) if (i.dataset.map !== '') i.style.background = mapColour(theme, +i.dataset.map);
    if (forced) this.view.drawNow(); // the printer does not wait
    else this.view.draw();
  }

  /** Puts a light picture for paper beside the canvas: a printer takes the canvas as it was. */
  print() {
    this.applyTheme('light');
    this.paper ??= this.stage.appendChild(el('img', {class: 'paper', alt: 'Picture of the maps'}));
    this.paper.src = this.canvas.toDataURL('image/png');
  }

  set(layer, on) {
    layer.on = on;
    layer.object.visible = on;
    if (layer.box) layer.box.checked = on;
    this.view.draw();
  }

  buildControls() {
    const list = el('div', {class: 'layers', role: 'group', 'aria-label': 'Layers'});
    this.layers.forEach((l) => {
      const id = 'layer-' + l.key;
      l.box = el('input', {type: 'checkbox', id});
      l.box.checked = l.on;
      l.mark = el('i', {class: 'swatch ' + l.kind});
      l.box.addEventListener('change', () => {
        this.set(l, l.box.checked);
        if (l === this.ghostLayer && l.on) this.showRival(this.rival);
      });
      list.append(el('label', {for: id}, l.box, l.kind === 'ramp' ? el('i', {class: 'swatch'}) : l.mark, el('span', {class: 'name'}, said(l.name)),
        l.count != null ? el('span', {class: 'count'}, l.count.toLocaleString('en-US')) : null));
      if (l.kind === 'ramp') {
        l.mark = el('i', {class: 'swatch ramp'});
        list.append(el('p', {class: 'hint'}, 'probability 0.5 ', l.mark, ' 1'));
      }
      for (const [key, text] of l.links) list.append(el('p', {class: 'hint'}, el('i', {class: 'swatch line ' + key, 'data-link': key}), ' ', text));
      if (l.hint) {
        list.append(el('p', {class: 'hint'}, l.hint));
      }
      if (l === this.ghostLayer) list.append(this.buildStepper());
    });
    const sliders = el('div', {class: 'sliders'});
    this.buildSliders(sliders);
    const buttons = el('div', {class: 'buttons', role: 'group', 'aria-label': 'Views'});
    const add = (text, title, action) => {
      const b = el('button', {type: 'button', title}, text);
      b.addEventListener('click', action);
      buttons.append(b);
    };
    add('Maps', 'Show the maps', () => this.preset('maps'));
    if (this.data.fused) add('Fused', 'Show the fused map by probability', () => this.preset('fused'));
    if (this.layers.some((l) => l.key === 'conflicts')) add('Conflicts', 'Show conflicts on pale maps', () => this.preset('conflicts'));
    if (this.ghosts) add('Rivals', 'Show rival poses', () => this.preset('rivals'));
    add('Top', 'Look from above (t)', () => this.view.look(0.001, -Math.PI / 2));
    add('Reset', 'Look at all (0)', () => this.view.look());
    const more = el('details', {class: 'controls', open: innerWidth > 700}, el('summary', {}, 'Layers'), list, sliders);
    more.append(el('details', {class: 'keys'}, el('summary', {}, 'Mouse, touch, keys'), el('ul', {},
      el('li', {}, 'Turn: drag, one finger, arrow keys'), el('li', {}, 'Move: right button, two fingers, shift and arrow keys'),
      el('li', {}, 'Nearer, farther: wheel, two fingers, + and −'), el('li', {}, 'From above: t. All: 0'))));
    this.stage.append(more, buttons, el('p', {class: 'scale'}, `grid: ${this.step} m`));
  }

  buildSliders(parent) {
    const slider = (id, text, min, max, step, value, show, action) => {
      const input = el('input', {type: 'range', id, min, max, step});
      input.value = value;
      const out = el('output', {for: id}, show(value));
      input.addEventListener('input', () => {
        out.textContent = show(+input.value);
        action(+input.value);
        this.view.draw();
      });
      parent.append(el('label', {for: id}, el('span', {class: 'name'}, text), out, input));
      action(+input.value);
    };
    const least = probabilityOf(128), low = this.box.min.z - 0.05, high = this.box.max.z + 0.05;
    slider('slider-probability', 'Probability at least', least.toFixed(2), 1, 0.005, least, (v) => v.toFixed(2),
      (v) => { this.shared.least.value = v <= least ? 0 : valueOfProbability(Math.min(v, 0.9995)); });
    const cut = this.ceiling();
    const step = Math.max((high - low) / 200, 1e-4);
    const digits = high - low > 100 ? 0 : high - low > 5 ? 1 : 2;
    const metres = (v) => v.toFixed(digits) + ' m';
    slider('slider-top', cut ? 'Height at most (ceiling cut)' : 'Height at most', low, high, step, cut ?? high, metres,
      (v) => { this.shared.heights.value[1] = v >= high - 1.5 * step ? 1e9 : v; });
    slider('slider-bottom', 'Height at least', low, high, step, low, metres,
      (v) => { this.shared.heights.value[0] = v <= low + 1.5 * step ? -1e9 : v; });
  }

  buildStepper() {
    const button = (text, title, by) => {
      const b = el('button', {type: 'button', title, 'aria-label': title}, text);
      b.addEventListener('click', () => this.showRival((this.rival + by + this.data.rivals.length) % this.data.rivals.length));
      return b;
    };
    this.rivalText = el('span', {class: 'name', 'aria-live': 'polite'}, `${this.data.rivals.length} to step through`);
    return el('div', {class: 'stepper'}, button('‹', 'Previous rival', -1), this.rivalText, button('›', 'Next rival', 1));
  }

  /** Shows a rival pose as a ghost. */
  showRival(i) {
    const r = this.data.rivals[i];
    this.rival = i;
    this.ghosts.forEach((g, k) => { g.visible = k === r.map; });
    const g = this.ghosts[r.map];
    g.matrix.copy(matrixOf(r.pose));
    g.matrixWorldNeedsUpdate = true;
    const of = this.data.kind === 'pair' ? '' : said(this.data.maps[r.map].name) + ', ';
    this.rivalText.textContent = `${of}rival ${r.rank}: ${(100 * r.agreement).toFixed(0)} % as well`;
    this.set(this.ghostLayer, true);
  }

  preset(which) {
    this.dim = which === 'conflicts';
    const isMap = (l) => l.key.startsWith('map-');
    const shown = new Set(this.maps.filter(({m}) => m.shown).map(({layer}) => layer));
    for (const l of this.layers) {
      if (which === 'fused') this.set(l, l.key === 'fused');
      else if (which === 'rivals') this.set(l, this.data.kind === 'pair' ? l.key === 'map-0' : shown.has(l));
      else this.set(l, isMap(l) ? shown.has(l) : l.key === 'conflicts' || (l.key === 'graph' && which === 'maps'));
    }
    this.view.points = this.points.length > 0 ? this.points : this.view.points;
    if (which === 'rivals') {
      this.showRival(this.rival);
      const m = this.ghosts[this.data.rivals[this.rival].map].matrix, place = this.maps[this.data.rivals[this.rival].map].geometry.cubes(1).place;
      const stride = 4 * Math.ceil(place.length / 4 / kPointsOfMap), ghost = [];
      for (let i = 0; i < place.length; i += stride) ghost.push(new Vector3(place[i], place[i + 1], place[i + 2]).applyMatrix4(m));
      this.view.points = [...this.points, ...ghost];
      this.view.look();
    }
    this.applyTheme();
  }

  placeLabels() {
    const {clientWidth: w, clientHeight: h} = this.stage;
    const p = new Vector3();
    for (const {label, at, layer} of this.labels) {
      p.copy(at).project(this.view.camera);
      label.style.display = layer.on && p.z < 1 ? '' : 'none';
      label.style.transform = `translate(${((p.x + 1) / 2) * w}px, ${((1 - p.y) / 2) * h}px) translate(-50%, -170%)`;
    }
  }
}

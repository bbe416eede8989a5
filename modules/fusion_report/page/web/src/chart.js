// SPDX-License-Identifier: BSD-3-Clause
// The evidence of a verdict as a chart: the threshold is in the middle; evidence for the pose is to the right.
import {el, figure, percent, svg} from './words.js';

const kBar = 150, kRow = 16;

/** Returns how far a value is beyond its threshold, -1 to 1: above 0 speaks for the pose. */
export function margin(value, limit, atLeast) {
  const good = atLeast ? value - limit : limit - value;
  const range = (good >= 0) === atLeast ? 1 - limit : limit;
  return Math.max(-1, Math.min(1, range > 0 ? good / range : Math.sign(good)));
}

function bar(m) {
  const x = kBar / 2, long = Math.max(2, Math.abs(m) * (x - 3));
  const good = m >= 0;
  return svg('svg', {viewBox: `0 0 ${kBar} ${kRow}`, width: kBar, height: kRow, 'aria-hidden': 'true', class: 'bar'},
    svg('rect', {x: 0, y: 3, width: kBar, height: kRow - 6, rx: 3, class: 'track'}),
    svg('rect', {x: good ? x : x - long, y: 3, width: long, height: kRow - 6, rx: 2, class: good ? 'for' : 'against'}),
    svg('line', {x1: x, x2: x, y1: 0, y2: kRow, class: 'limit'}));
}

/** Returns the chart of a match, or null. `path` leads to the match in the report. */
export function evidenceChart(report, path, limits, inTeam) {
  const m = path.reduce((v, k) => v?.[k], report);
  if (!m || m.by_edges) return null;
  const at = (key) => [...path, key];
  const rows = [];
  const row = (name, what, shown, value, limit, atLeast, limitText) => {
    if (value == null) return;
    const beyond = margin(value, limit, atLeast);
    rows.push(el('tr', {title: what},
      el('th', {scope: 'row'}, name), el('td', {class: 'mark ' + (beyond >= 0 ? 'good' : 'bad')}, beyond >= 0 ? '✓' : '✗'),
      el('td', {}, bar(beyond)), el('td', {class: 'number'}, shown),
      el('td', {class: 'limit'}, (atLeast ? '≥ ' : '≤ ') + limitText)));
  };
  const pc = (x) => +(100 * x).toFixed(1) + '\u2009%';
  row('Overlap', 'Share of matched voxels', percent(report, at('overlap')), m.overlap, limits.min_overlap, true, pc(limits.min_overlap));
  row('Inliers', 'Share of pairs that lie close together', percent(report, at('inlier_ratio')), m.inlier_ratio, m.inlier_threshold, true, pc(m.inlier_threshold));
  row('Conflicts', 'Obstacles in seen free space of the other map', percent(report, at('free_space_conflict_ratio')), m.free_space_conflict_ratio, limits.max_free_conflict, false, pc(limits.max_free_conflict));
  if (inTeam) {
    row('Rival place', 'How much of the agreement another place reaches', figure(report, at('runner_up'), 2), m.runner_up, limits.max_team_runner_up, false, String(limits.max_team_runner_up));
  } else {
    row('Rival pose', 'How much of the agreement another pose reaches', figure(report, at('rival_weight'), 2), m.rival_weight, limits.max_runner_up, false, String(limits.max_runner_up));
    row('Probability', 'That the pose is right', percent(report, at('probability')), m.probability, limits.min_probability, true, pc(limits.min_probability));
  }
  if (rows.length === 0) return null;
  return el('table', {class: 'evidence'},
    el('thead', {}, el('tr', {}, el('th', {}), el('th', {}),
      el('th', {class: 'sides'}, el('span', {}, 'against'), el('span', {}, 'for')), el('th', {}), el('th', {}, 'limit'))),
    el('tbody', {}, ...rows));
}

/** Times of the steps as bars. */
export function timesChart(report) {
  const steps = Object.keys(report.seconds ?? {});
  const most = Math.max(1e-9, ...steps.map((s) => report.seconds[s]));
  return el('table', {class: 'times'}, el('tbody', {}, ...steps.map((s) => el('tr', {},
    el('th', {scope: 'row'}, s),
    el('td', {}, svg('svg', {viewBox: '0 0 100 8', width: 100, height: 8, 'aria-hidden': 'true'},
      svg('rect', {x: 0, y: 1, height: 6, rx: 2, width: Math.max(1, (100 * report.seconds[s]) / most), class: 'time'}))),
    el('td', {class: 'number'}, figure(report, ['seconds', s], 2, {unit: '\u2009s'}))))));
}

/** Root mean square distance of the pairs over the iterations. */
export function iterationsChart(report, path) {
  const all = [...path, 'iterations'].reduce((v, k) => v?.[k], report) ?? [];
  const its = all.filter((i) => i.pairs > 0);
  if (its.length < 2) return null;
  const w = 340, h = 90, rms = its.map((i) => Math.sqrt(i.mse_m2)), top = Math.max(...rms) || 1;
  const x = (i) => 34 + ((w - 40) * i) / (its.length - 1), y = (v) => h - 18 - ((h - 28) * v) / top;
  const dots = its.map((it, i) => svg('circle', {cx: x(i), cy: y(rms[i]), r: 3, class: it.level === 'edge' ? 'dot-edge' : 'dot-voxel'},
    svg('title', {}, `${it.level} level: ${it.pairs} pairs, ${rms[i].toFixed(3)} m`)));
  const text = (at, y0, t, anchor = 'start') => svg('text', {x: at, y: y0, 'text-anchor': anchor}, t);
  return el('figure', {},
    svg('svg', {viewBox: `0 0 ${w} ${h}`, class: 'iterations', role: 'img', 'aria-label': 'Distance of the pairs over the iterations'},
      svg('line', {x1: 34, x2: w - 6, y1: y(0), y2: y(0), class: 'axis'}),
      svg('polyline', {points: rms.map((v, i) => `${x(i)},${y(v)}`).join(' '), class: 'curve'}), ...dots,
      text(30, y(top) + 4, top.toFixed(2), 'end'), text(30, y(0) + 3, '0 m', 'end'), text(34, h - 3, 'iterations: '),
      svg('circle', {cx: 98, cy: h - 7, r: 3, class: 'dot-edge'}), text(104, h - 3, 'on edges'),
      svg('circle', {cx: 158, cy: h - 7, r: 3, class: 'dot-voxel'}), text(164, h - 3, 'on voxels')),
    el('figcaption', {}, 'Root mean square distance of the pairs'));
}

// SPDX-License-Identifier: BSD-3-Clause
// The report in words: verdict, evidence, poses, maps, times. Each number comes from the report.
import {evidenceChart, iterationsChart, timesChart} from './chart.js';
import {el, figure, percent, said, section, table} from './words.js';

const kVerdicts = {
  accepted: ['✓', 'Accepted'], ambiguous: ['?', 'Ambiguous'], rejected: ['✗', 'Rejected'],
  edges: ['·', 'Placed by edges'], given: ['→', 'Given pose'], map: ['▦', 'Map'],
};

/** Returns the kind of verdict of a match of the report. */
export function verdictOf(match) {
  if (!match) return 'given';
  if (match.accepted) return 'accepted';
  return match.ambiguous ? 'ambiguous' : match.by_edges ? 'edges' : 'rejected';
}

export function badge(kind) {
  const [mark, text] = kVerdicts[kind];
  return el('span', {class: 'badge ' + kind}, el('span', {'aria-hidden': 'true', class: 'sign'}, mark), text);
}

const kAxes = [['x', 'x', 3, '\u2009m'], ['y', 'y', 3, '\u2009m'], ['z', 'z', 3, '\u2009m'],
  ['yaw_deg', 'yaw', 2, '°'], ['pitch_deg', 'pitch', 2, '°'], ['roll_deg', 'roll', 2, '°']];

/** Standard deviation of the i-th value of a pose, from its covariance. */
function deviation(pose, i) {
  const v = pose.covariance?.[i]?.[i];
  if (!(v > 0)) return '';
  const s = Math.sqrt(v) * (i < 3 ? 1 : 180 / Math.PI);
  if (s > 500) return 'free';
  return '± ' + (s < 0.001 ? s.toExponential(0) : s.toPrecision(2)) + (i < 3 ? '\u2009m' : '°');
}

function poseTable(report, path) {
  const pose = path.reduce((v, k) => v?.[k], report);
  return table(['', 'value', 'std. deviation'], kAxes.map(([key, name, digits, unit], i) =>
    [name, figure(report, [...path, key], digits, {unit}), deviation(pose, i)]), {class: 'pose'});
}

/** The reasons of a verdict: first those against the pose, marked by a minus. */
const reasonsOf = (match) => el('ul', {class: 'reasons signed'}, ...(match.reasons ?? []).map((r, i) =>
  el('li', {class: i < (match.reasons_against ?? 0) ? 'against' : 'for'}, said(r))));

function sureness(report, path) {
  const m = path.reduce((v, k) => v?.[k], report);
  if (!m) return null;
  const p = el('p', {class: 'sure'}, 'Probability that the pose is right: ', percent(report, [...path, 'probability']));
  if (m.deviation_m < 500) p.append('. Standard deviations of the middle of map B in its least certain direction: ',
    figure(report, [...path, 'deviation_m'], 3, {unit: '\u2009m'}), ', and of the rotation about its least certain axis: ',
    figure(report, [...path, 'deviation_deg'], 3, {unit: '°'}), '.');
  return p;
}

function mapsTable(report) {
  const files = new Set(report.maps.map((m) => m.path)).size > 0;
  return section('Maps', table(['map', 'voxel', 'occupied', 'free', 'entropy of occupied', 'of known'], report.maps.map((m, i) => [
    el('span', {title: files ? said(m.path) : null}, said(m.role)),
    figure(report, ['maps', i, 'resolution_m'], 3, {unit: '\u2009m'}),
    figure(report, ['maps', i, 'occupied_voxels'], 0), figure(report, ['maps', i, 'free_voxels'], 0),
    figure(report, ['maps', i, 'mean_entropy_occupied_nats'], 4), figure(report, ['maps', i, 'mean_entropy_known_nats'], 4)])),
  el('p', {class: 'note'}, 'Entropies are means over voxels, in nats.'),
  el('ul', {class: 'files'}, ...report.maps.map((m) => el('li', {}, el('b', {}, said(m.role)), ' ', el('code', {}, said(m.path))))));
}

function rivalsSection(report, scene, show) {
  const list = report.match?.hypotheses ?? [];
  if (list.length < 2) return null;
  const best = list[0].agreement || 1, kLeast = 0.01;
  const shown = list.map((h, i) => i).filter((i) => i < 2 || list[i].agreement >= kLeast * best);
  const figureAt = (i, key, digits, unit = '') => figure(report, ['match', 'hypotheses', i, 'pose', key], digits, {unit});
  const rows = shown.map((i) => {
    const at = (scene.rivals ?? []).findIndex((r) => r.map === 1 && r.rank === i);
    return [i === 0 ? 'match' : 'rival ' + i,
      el('span', {class: 'figure', title: String(list[i].agreement)}, ((100 * list[i].agreement) / best).toFixed(1) + '\u2009%'),
      figureAt(i, 'x', 2), figureAt(i, 'y', 2), figureAt(i, 'yaw_deg', 1, '°'),
      show && at >= 0 ? button('show', () => show(at)) : ''];
  });
  const others = list.length - shown.length;
  return section('Rival poses', table(['pose', 'agreement', 'x', 'y', 'yaw', ''], rows, {class: 'rivals'}),
    el('p', {class: 'note'}, 'The agreement of the maps at a pose is relative to the match.' +
      (others > 0 ? ` ${others} other poses agree less than 1 % as well.` : '')));
}

function button(text, action) {
  const b = el('button', {type: 'button', class: 'small'}, text);
  b.addEventListener('click', action);
  return b;
}

function robotsSection(report, scene, swatch) {
  const rows = report.robots.map((r, i) => {
    const kind = !r.match ? null : verdictOf(r.match);
    return [el('span', {}, swatch(scene.maps[i]), ' ', said(r.robot)),
      kind ? badge(kind) : 'keeps its frame', r.matched_with ? said(r.matched_with) : '',
      r.match ? percent(report, ['robots', i, 'match', 'overlap']) : '',
      r.pose ? figure(report, ['robots', i, 'pose', 'x'], 2) : '', r.pose ? figure(report, ['robots', i, 'pose', 'y'], 2) : '',
      r.pose ? figure(report, ['robots', i, 'pose', 'yaw_deg'], 1, {unit: '°'}) : ''];
  });
  const details = report.robots.map((r, i) => r.match && el('div', {class: 'robot'},
    el('h3', {}, swatch(scene.maps[i]), ' ', said(r.robot), ' ', badge(verdictOf(r.match))), reasonsOf(r.match),
    el('details', {}, el('summary', {}, 'Evidence and pose'), evidenceChart(report, ['robots', i, 'match'], scene.limits, true),
      poseTable(report, ['robots', i, 'pose']))));
  return [section('Robots', table(['robot', 'verdict', 'with', 'overlap', 'x', 'y', 'yaw'], rows, {class: 'robots'})),
    section('Why', ...details)];
}

/** The matches of all pairs of a team. */
function pairsSection(report) {
  if (!report.pairs) return null;
  const kindOf = (p) => (p.accepted ? 'accepted' : p.ambiguous ? 'ambiguous' : 'rejected');
  const holding = report.pairs.filter((p) => p.holds).length;
  return section('Pairs', el('details', {}, el('summary', {}, `${report.pairs.length} matches, ${holding} hold in the result`),
    table(['pair', 'alone', 'probability', 'overlap', 'holds'], report.pairs.map((p, i) => [
      `${said(p.a)} – ${said(p.b)}`, badge(kindOf(p)), percent(report, ['pairs', i, 'probability']), percent(report, ['pairs', i, 'overlap']),
      p.holds ? '✓ yes' : p.accepted ? '✗ no' : 'no']), {class: 'robots'})));
}

/** Returns the headline: kind of verdict, title and one sentence. */
function headline(report, scene) {
  if (report.robots) {
    const joined = report.robots.filter((r) => r.joined).length;
    const kind = joined === report.robots.length ? 'accepted' : joined > 1 ? 'ambiguous' : 'rejected';
    return [kind, `${joined} of ${report.robots.length} maps joined`];
  }
  if (report.match) return [verdictOf(report.match), kVerdicts[verdictOf(report.match)][1]];
  return report.pose ? ['given', 'Merged at the given pose'] : ['map', scene.maps.length > 1 ? `${scene.maps.length} maps` : 'Map'];
}

/** Fills the panel. `show(i)` shows the i-th rival in the picture; null without a picture. */
export function fillPanel(panel, report, scene, {show, swatch}) {
  const [kind, title] = headline(report, scene);
  const names = report.maps.map((m) => said(m.role)).join(', ');
  document.title = `${title} · map-fusion ${said(report.command)}`;
  panel.append(el('header', {class: 'verdict ' + kind},
    el('p', {class: 'command'}, 'map-fusion ' + said(report.command) + ' · ' + names),
    el('h1', {}, el('span', {class: 'sign', 'aria-hidden': 'true'}, kVerdicts[kind][0]), title),
    report.match ? sureness(report, ['match']) : null));
  if (report.match) {
    panel.append(section('Why', reasonsOf(report.match)));
    const chart = evidenceChart(report, ['match'], scene.limits, false);
    if (chart) panel.append(section('Evidence', chart, el('p', {class: 'note'},
      'The middle line is the limit. A bar to the right speaks for the pose, a bar to the left against it. A full bar is as far as the value can go.')));
  }
  if (report.robots) panel.append(...robotsSection(report, scene, swatch));
  const pairs = pairsSection(report);
  if (pairs) panel.append(pairs);
  if (report.pose) panel.append(section('Pose of B in the frame of A', poseTable(report, ['pose'])));
  const rivals = rivalsSection(report, scene, show);
  if (rivals) panel.append(rivals);
  if (report.policy && report.maps.some((m) => m.role === 'fused')) panel.append(section('Merged', el('p', {}, 'Rule for voxels that both maps know: ', el('code', {}, said(report.policy)))));
  panel.append(mapsTable(report));
  const its = report.match && iterationsChart(report, ['match']);
  if (its) panel.append(section('Registration', its));
  if (report.notes) panel.append(section('Notes', el('ul', {class: 'reasons'}, ...report.notes.map((n) => el('li', {}, said(n))))));
  panel.append(section('Times', timesChart(report)));
  const all = el('pre', {}, '');
  const details = el('details', {class: 'all'}, el('summary', {}, 'All figures, as --json writes them'), all);
  details.addEventListener('toggle', () => {
    if (!all.firstChild || all.textContent === '') all.textContent = JSON.stringify(report, (k, v) => (typeof v === 'string' ? said(v) : v), 1);
  });
  panel.append(section('Figures', details));
}

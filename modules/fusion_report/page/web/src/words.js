// SPDX-License-Identifier: BSD-3-Clause
// Small makers of elements. Text from outside goes through textContent only.
import {printable} from './data.js';

/** Makes an element. `content`: texts and elements. */
export function el(name, attributes = {}, ...content) {
  const e = document.createElement(name);
  for (const [key, value] of Object.entries(attributes))
    if (value === true) e.setAttribute(key, '');
    else if (value !== false && value != null) e.setAttribute(key, value);
  e.append(...content.filter((c) => c != null));
  return e;
}

export function svg(name, attributes = {}, ...content) {
  const e = document.createElementNS('http://www.w3.org/2000/svg', name);
  for (const [key, value] of Object.entries(attributes)) e.setAttribute(key, value);
  e.append(...content);
  return e;
}

/** Text from outside. */
export const said = (text) => printable(text);

/**
 * A number of the report. It knows its place in the report, so that anybody can compare both.
 * \param[in] report The report. \param[in] path Keys, for example ['match', 'overlap'].
 * \param[in] digits Digits after the point. \param[in] scale Factor of the shown number. \param[in] unit Text behind.
 */
export function figure(report, path, digits, {scale = 1, unit = ''} = {}) {
  const value = path.reduce((v, k) => (v == null ? v : v[k]), report);
  if (value == null) return el('span', {class: 'figure'}, 'unknown');
  const e = el('span', {class: 'figure', 'data-path': JSON.stringify(path), 'data-value': String(value),
    'data-digits': digits, 'data-scale': scale, title: String(value)});
  const shown = digits === 0 && scale === 1 ? value.toLocaleString('en-US') : (value * scale).toFixed(digits);
  e.append(shown + unit);
  return e;
}
export const percent = (report, path, digits = 1) => figure(report, path, digits, {scale: 100, unit: '\u2009%'});

export function table(head, rows, attributes = {}) {
  return el('div', {class: 'scroll'}, el('table', attributes,
    el('thead', {}, el('tr', {}, ...head.map((h) => el('th', {scope: 'col'}, h)))),
    el('tbody', {}, ...rows.map((r) => el('tr', {}, ...r.map((c, i) => el(i === 0 ? 'th' : 'td', i === 0 ? {scope: 'row'} : {}, c)))))));
}

export function section(title, ...content) {
  return el('section', {}, el('h2', {}, title), ...content);
}

// SPDX-License-Identifier: BSD-3-Clause
// Bundles src/ and three.js into dist/page.html, and writes the hashes of all sources beside it.
// scripts/build_page.sh runs it after `npm ci`.
import {createHash} from 'node:crypto';
import {readdirSync, readFileSync, mkdirSync, writeFileSync} from 'node:fs';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {build, transform} from 'esbuild';

const here = dirname(fileURLToPath(import.meta.url));
const read = (name) => readFileSync(join(here, name), 'utf8');

const bundled = await build({entryPoints: [join(here, 'src/main.js')], bundle: true, minify: true, write: false,
  format: 'iife', target: 'es2020', charset: 'ascii', legalComments: 'none'});
const license = read('node_modules/three/LICENSE').trim().replaceAll('*/', '');
// No text of the script may end it or begin a comment.
const script = (`/*! three.js\n${license}\n*/\n` + bundled.outputFiles[0].text.trim())
  .replaceAll('</script', '<\\/script').replaceAll('<!--', '<\\!--');
const style = (await transform(read('src/page.css'), {loader: 'css', minify: true, charset: 'ascii'})).code.trim();
const hash = createHash('sha256').update(script).digest('base64');
const page = read('src/template.html').replace('@STYLE@', () => style).replace('@SCRIPT_HASH@', () => hash)
  .replace('@SCRIPT@', () => script);

mkdirSync(join(here, 'dist'), {recursive: true});
writeFileSync(join(here, 'dist/page.html'), page);
// What the page was built from. sha256sum reads it: scripts/build_page.sh --check.
const sums = ['build.mjs', 'package-lock.json', 'package.json', ...readdirSync(join(here, 'src')).map((f) => 'src/' + f),
  'dist/page.html'].map((f) => createHash('sha256').update(readFileSync(join(here, f))).digest('hex') + '  ' + f + '\n');
writeFileSync(join(here, 'dist/sha256sums'), sums.join(''));
console.log(`dist/page.html: ${page.length} bytes`);

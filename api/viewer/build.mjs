// Bundles the page: node build.mjs --out FOLDER [--modules NODE_MODULES]. Everything that the page loads ends up in FOLDER.
import { copyFileSync, mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { dirname, join, resolve } from 'node:path';
import { fileURLToPath } from 'node:url';
import { parseArgs } from 'node:util';

const here = dirname(fileURLToPath(import.meta.url));
const { values } = parseArgs({ options: { out: { type: 'string', default: 'dist' }, modules: { type: 'string' } } });
const modules = resolve(values.modules ?? join(here, 'node_modules'));
const out = resolve(values.out);
const { build } = createRequire(join(modules, 'package.json'))('esbuild');

mkdirSync(out, { recursive: true });
await build({
  entryPoints: { app: join(here, 'src/main.ts') },
  outdir: out,
  nodePaths: [modules],
  bundle: true,
  minify: true,
  format: 'esm',
  target: ['es2022'],
  legalComments: 'eof',
  logLevel: 'warning',
});
await build({ entryPoints: [join(here, 'src/app.css')], outdir: out, minify: true, logLevel: 'warning' });
for (const file of ['index.html', 'favicon.svg']) copyFileSync(join(here, 'src', file), join(out, file));

// The licences of what is bundled travel with it.
const bundled = ['three', '@dagrejs/dagre', '@dagrejs/graphlib'];
const licences = bundled.map((name) => {
  const folder = join(modules, name);
  const { version } = JSON.parse(readFileSync(join(folder, 'package.json'), 'utf8'));
  return `${name} ${version}\n\n${readFileSync(join(folder, 'LICENSE'), 'utf8').trim()}\n`;
});
writeFileSync(join(out, 'third_party.txt'), licences.join('\n----------------------------------------\n\n'));

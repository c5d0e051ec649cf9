// Bundles src/ and the packages into the two pages, of reports and of live runs: `node build.mjs OUT_FOLDER`.
import { build } from 'esbuild';
import { mkdir, readFile, writeFile } from 'node:fs/promises';
import { join } from 'node:path';

const out = process.argv[2] ?? 'dist';
const version = async (name) => JSON.parse(await readFile(new URL(`node_modules/${name}/package.json`, import.meta.url))).version;
const define = { VERSIONS: JSON.stringify({ three: await version('three'), uPlot: await version('uplot') }) };
const here = (path) => new URL(path, import.meta.url).pathname;

async function bundle(script, html, page) {
  const result = await build({
    entryPoints: [here(script)],
    bundle: true,
    minify: true,
    format: 'iife',
    target: ['es2022'],
    legalComments: 'inline', // the packages' licences go with them
    outdir: here('out'),
    write: false,
    logLevel: 'warning',
    define,
  });
  const text = (ending) => result.outputFiles.find((file) => file.path.endsWith(ending)).text;
  // Within a script element only its own end matters; functions in replace() keep `$` as it is.
  const whole = (await readFile(here(html), 'utf8'))
    .replace('/* style */', () => text('.css'))
    .replace('/* script */', () => text('.js').replaceAll('</script', '<\\/script'));
  await writeFile(join(out, page), whole);
}

await mkdir(out, { recursive: true });
await bundle('src/main.js', 'src/page.html', 'page.html');
await bundle('src/live/main.js', 'src/live/live.html', 'live.html');

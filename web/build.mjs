// Bundles src/ and the packages into one page: `node build.mjs OUT.html`.
import { build } from 'esbuild';
import { readFile, writeFile } from 'node:fs/promises';

const out = process.argv[2] ?? 'page.html';
const version = async (name) => JSON.parse(await readFile(new URL(`node_modules/${name}/package.json`, import.meta.url))).version;

const here = (path) => new URL(path, import.meta.url).pathname;
const result = await build({
  entryPoints: [here('src/main.js')],
  bundle: true,
  minify: true,
  format: 'iife',
  target: ['es2022'],
  legalComments: 'inline', // the packages' licences go with them
  outdir: here('out'),
  write: false,
  logLevel: 'warning',
  define: { VERSIONS: JSON.stringify({ three: await version('three'), uPlot: await version('uplot') }) },
});
const text = (ending) => result.outputFiles.find((file) => file.path.endsWith(ending)).text;

// Within a script element only its own end matters; functions in replace() keep `$` as it is.
const page = (await readFile(here('src/page.html'), 'utf8'))
  .replace('/* style */', () => text('.css'))
  .replace('/* script */', () => text('.js').replaceAll('</script', '<\\/script'));
await writeFile(out, page);

// Bundles src/ into the two pages, of reports and of live runs, and the packages that both use into a script that the
// program, which holds it once, puts into either: `node build.mjs OUT_FOLDER`.
import { build } from 'esbuild';
import { mkdir, readFile, readdir, writeFile } from 'node:fs/promises';
import { join } from 'node:path';

const out = process.argv[2] ?? 'dist';
const version = async (name) => JSON.parse(await readFile(new URL(`node_modules/${name}/package.json`, import.meta.url))).version;
const define = { VERSIONS: JSON.stringify({ three: await version('three'), uPlot: await version('uplot') }) };
const here = (path) => new URL(path, import.meta.url).pathname;
const COMMON = 'PlumblinePackages'; // the script's one global name
const ADDONS = ['controls/OrbitControls', 'libs/meshopt_decoder.module', 'lines/LineMaterial', 'lines/LineSegments2', 'lines/LineSegmentsGeometry'].map((name) => `three/examples/jsm/${name}.js`);

const options = {
  bundle: true,
  minify: true,
  format: 'iife',
  target: ['es2022'],
  legalComments: 'inline', // the packages' licences go with them
  outdir: here('out'),
  write: false,
  logLevel: 'warning',
  define,
};
// Within a script element only its own end matters.
const inScript = (text) => text.replaceAll('</script', '<\\/script');

/** What src/ uses of three, as `THREE.Name`: the rest is left out. */
async function usedNames() {
  const names = new Set();
  for (const file of await readdir(here('src'), { recursive: true }))
    if (file.endsWith('.js')) for (const [, name] of (await readFile(here(`src/${file}`), 'utf8')).matchAll(/THREE\.(\w+)/g)) names.add(name);
  return [...names].sort();
}

async function packages() {
  const contents = [`export { ${(await usedNames()).join(', ')} } from 'three';`, ...ADDONS.map((name) => `export * from '${name}';`)].join('\n');
  const result = await build({ ...options, globalName: COMMON, stdin: { contents, resolveDir: here('.') } });
  await writeFile(join(out, 'packages.js'), inScript(result.outputFiles[0].text));
}

/** In the pages, `import … from 'three'` and from its addons takes what the script of packages has left. */
const fromPackages = {
  name: 'packages',
  setup({ onResolve, onLoad }) {
    onResolve({ filter: /^three$/ }, () => ({ path: 'three', namespace: 'packages' }));
    onResolve({ filter: /^three\// }, ({ path }) => {
      if (!ADDONS.includes(path)) throw new Error(`${path} is not among the packages that build.mjs bundles`);
      return { path: 'three', namespace: 'packages' };
    });
    onLoad({ filter: /.*/, namespace: 'packages' }, () => ({ contents: `module.exports = ${COMMON};` }));
  },
};

async function page(script, html, name) {
  const result = await build({ ...options, entryPoints: [here(script)], plugins: [fromPackages] });
  const text = (ending) => result.outputFiles.find((file) => file.path.endsWith(ending)).text;
  // Functions in replace() keep `$` as it is.
  const whole = (await readFile(here(html), 'utf8'))
    .replace('/* style */', () => text('.css'))
    .replace('/* script */', () => inScript(text('.js')));
  await writeFile(join(out, name), whole);
}

await mkdir(out, { recursive: true });
await packages();
await page('src/main.js', 'src/page.html', 'page.html');
await page('src/live/main.js', 'src/live/live.html', 'live.html');

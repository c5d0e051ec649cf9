// Drives report.html as a person would, in a headless Chromium: `node test/report.test.mjs PLUMBLINE`.
// Exit code 77 where there is no Chromium: ctest then says "skipped".
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { pathToFileURL } from 'node:url';
import { launch, look, openPage } from './browser.mjs';

const program = process.argv[2];
const FRAMES = 12;
const DUMPED = 5;
const ROW = 8;

const folder = mkdtempSync(join(tmpdir(), 'plumbline-report-'));
const out = join(folder, 'out');
const plumbline = (...words) => execFileSync(program, words, { encoding: 'utf8' });
let browser;

/** The rows of a table with named columns. */
function csv(path) {
  const [head, ...lines] = readFileSync(path, 'utf8').trim().split('\n').map((line) => line.split(','));
  return lines.map((line) => Object.fromEntries(line.map((value, i) => [head[i], value])));
}

const open = (path, options) => openPage(browser, pathToFileURL(path).href, (url) => /^(file|data|blob):/.test(url), options);

const marker = (page) => page.evaluate(() => window.plumbline.viewer.marker.position.toArray());

before(async () => {
  plumbline('simulate', '--scene', 'desk', '--trajectory', 'orbit', '--size', '160x120', '--frames', String(FRAMES), '-o', join(folder, 'desk'), '--quiet');
  plumbline('run', join(folder, 'desk'), '-o', out, '--set', 'volume.resolution=256', '--set', 'volume.side=5', '--detail', 'off', '--dump-icp', String(DUMPED), '--quiet');
  browser = await launch();
});

after(async () => {
  await browser?.close();
  rmSync(folder, { recursive: true, force: true });
});

test('the report of a run', async (t) => {
  const { page, complaints, close } = await open(join(out, 'report.html'));
  const rows = csv(join(out, 'frames.csv'));
  assert.equal(rows.length, FRAMES);

  await t.test('says what came of it', async () => {
    assert.match(await page.textContent('#verdict'), /All 12 frames were tracked, and the camera's path is within [\d.]+\smm/);
    assert.match(await page.textContent('#facts'), /12 of 12/);
    assert.match(await page.textContent('#detail-list'), /--dump-icp 5/);
    assert.match(await page.textContent('#config-text'), /\[tracking\]/);
  });

  await t.test('shows the mesh and the paths', async () => {
    const whole = await look(page);
    assert.ok(whole.filled > 0.1, `only ${whole.filled} of the view is filled`);
    assert.ok((await page.locator('#scene canvas').boundingBox()).height > 400);
    assert.ok(whole.colors > 50, `${whole.colors} colours`);
    const layers = await page.$$eval('#layers .chip[aria-pressed=true]', (chips) => chips.map((chip) => chip.textContent));
    assert.deepEqual(layers, ['Mesh', 'Estimate', 'Truth', 'Difference', 'Camera']);
    await page.click('#layers .chip >> text=Mesh');
    const paths = await look(page);
    assert.ok(paths.filled > 0.0005 && paths.filled < 0.5 * whole.filled, `${paths.filled} of the view without the mesh`);
    await page.click('#layers .chip >> text=Mesh');
  });

  await t.test('the slider moves the camera', async () => {
    const position = (row) => ['tx', 'ty', 'tz'].map((name) => Number(rows[row][name]));
    const close = (a, b) => a.every((x, i) => Math.abs(x - b[i]) < 1e-5);
    assert.ok(close(await marker(page), position(0)));
    await page.fill('#frame', String(ROW));
    assert.ok(close(await marker(page), position(ROW)), `${await marker(page)} is not ${position(ROW)}`);
    assert.ok(!close(position(0), position(ROW)));
    assert.match(await page.textContent('#readout'), new RegExp(`frame${rows[ROW].index}`));
  });

  await t.test('the plots hold every frame', async () => {
    const plots = await page.evaluate(() => window.plumbline.plots.map((plot) => plot.data.map((line) => Array.from(line))));
    assert.equal(plots.length, 6);
    for (const lines of plots) for (const line of lines) assert.equal(line.length, FRAMES);
    const [, [index, median]] = plots;
    rows.forEach((row, i) => {
      assert.equal(index[i], Number(row.index));
      if (i > 0) assert.ok(Math.abs(median[i] - 1e3 * Number(row.median_distance_m)) < 1e-3);
    });
    assert.equal(median[0], null); // the first frame is registered to nothing
    const top = plots.at(-1)[1]; // the stages, one on the other
    assert.ok(Math.abs(top[ROW] - Number(rows[ROW].total_ms)) < 0.01);
  });

  await t.test('a press on a plot moves the slider', async () => {
    const plot = page.locator('#plots .u-over').first();
    const { width, height } = await plot.boundingBox();
    await plot.click({ position: { x: width - 2, y: height / 2 } });
    assert.equal(await page.inputValue('#frame'), String(FRAMES - 1));
  });

  await t.test('looks through the recording camera', async () => {
    await page.click('text=Camera’s view');
    const eye = await page.evaluate(() => window.plumbline.viewer.camera.position.toArray());
    assert.deepEqual(eye, await marker(page));
    const { filled } = await look(page);
    assert.ok(filled > 0.3, `${filled} of the view is filled`);
    await page.click('text=Camera’s view');
  });

  await t.test('shows the distances over the iterations', async () => {
    const trace = JSON.parse(readFileSync(join(out, `icp_${DUMPED}.json`), 'utf8'));
    assert.equal(await page.locator('#distribution tbody tr').count(), trace.iterations.length);
    const lines = await page.evaluate(() => window.plumbline.distribution.plot.chart.data.length);
    assert.equal(lines, trace.iterations.length + 1);
  });

  assert.deepEqual(complaints, []);
  await close();
});

test('fits a phone, and a dark room', async () => {
  const { page, complaints, close } = await open(join(out, 'report.html'), { viewport: { width: 390, height: 800 }, colorScheme: 'dark' });
  assert.equal(await page.evaluate(() => document.documentElement.scrollWidth), 390);
  const { background, filled } = await look(page);
  assert.ok((background & 0xff) < 0x40, `background ${background.toString(16)}`);
  assert.ok(filled > 0.1);
  assert.deepEqual(complaints, []);
  await close();
});

test('a page of a mesh alone', async () => {
  const path = join(folder, 'mesh.html');
  plumbline('view', join(out, 'mesh.ply'), '--no-open', '-o', path);
  const { page, complaints, close } = await open(path);
  assert.ok((await look(page)).filled > 0.05);
  assert.ok((await page.locator('#scene canvas').boundingBox()).height > 250);
  assert.equal(await page.locator('#plots').isVisible(), false);
  assert.equal(await page.textContent('#title'), 'mesh.ply');
  assert.deepEqual(complaints, []);
  await close();
});

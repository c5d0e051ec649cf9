// Drives the live page as a person would, in a headless Chromium: `node test/live.test.mjs PLUMBLINE`. Runs are slow or
// fast as the machine is, so nothing here waits for a time, but for what is to be seen.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync, writeFileSync } from 'node:fs';
import http from 'node:http';
import net from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import test, { after, before } from 'node:test';
import { deflateSync } from 'node:zlib';
import { launch, look, openPage, until } from './browser.mjs';

const program = process.argv[2];
const FRAMES = 150;
const COVERED = [70, 105]; // frames that show nothing
const SMALL = ['--set', 'volume.resolution=256', '--set', 'volume.side=5', '--detail', 'off', '--no-color'];

const folder = mkdtempSync(join(tmpdir(), 'plumbline-live-'));
const environment = { ...process.env, DISPLAY: '', WAYLAND_DISPLAY: '', BROWSER: '' };
const running = new Set();
let halfSaid, stranded; // of the strangers' test, for the one at the end
let browser;

/** A run with a page: its address, and its exit code once it ends. */
function start(...words) {
  const run = spawn(program, words, { env: environment, stdio: ['ignore', 'pipe', 'pipe'] });
  running.add(run);
  run.output = '';
  run.done = new Promise((resolve) => run.on('exit', (code) => resolve(code)));
  run.url = new Promise((resolve, reject) => {
    for (const stream of [run.stdout, run.stderr])
      stream.on('data', (bytes) => {
        run.output += bytes;
        const found = run.output.match(/view {7}(http:\S+)/);
        if (found) resolve(new URL(found[1]));
      });
    run.done.then(() => reject(new Error(`it ended: ${run.output}`)));
  });
  run.url.catch(() => {}); // whoever waits for it is told
  return run;
}

const open = async (run, options) => {
  const url = await run.url;
  return openPage(browser, url.href, (asked) => /^(data|blob):/.test(asked) || asked.startsWith(url.origin), options);
};
const grown = () => window.plumbline.state.frame && window.plumbline.viewer.surface.triangles > 1000;
const state = (page) => page.evaluate(() => window.plumbline.state);
const count = (page) => page.evaluate(() => window.plumbline.viewer.surface.triangles);

/** A 16-bit image of zeros. */
function blankPng(width, height) {
  const table = Array.from({ length: 256 }, (_, n) => [...Array(8)].reduce((c) => (c & 1 ? 0xedb88320 ^ (c >>> 1) : c >>> 1), n));
  const crc = (bytes) => ~bytes.reduce((c, byte) => table[(c ^ byte) & 0xff] ^ (c >>> 8), ~0) >>> 0;
  const chunk = (name, data) => {
    const body = Buffer.concat([Buffer.from(name), data]);
    const ends = [Buffer.alloc(4), Buffer.alloc(4)];
    ends[0].writeUInt32BE(data.length);
    ends[1].writeUInt32BE(crc(body));
    return Buffer.concat([ends[0], body, ends[1]]);
  };
  const header = Buffer.from([0, 0, 0, 0, 0, 0, 0, 0, 16, 0, 0, 0, 0]);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  return Buffer.concat([Buffer.from('\x89PNG\r\n\x1a\n', 'latin1'), chunk('IHDR', header), chunk('IDAT', deflateSync(Buffer.alloc((1 + 2 * width) * height))), chunk('IEND', Buffer.alloc(0))]);
}

/** The camera is covered for a second, and then sees again what it saw before, backwards. */
function cover(path) {
  writeFileSync(join(path, 'depth', 'blank.png'), blankPng(160, 120));
  for (const list of ['depth.txt', 'rgb.txt']) {
    const rows = readFileSync(join(path, list), 'utf8').split('\n').filter((row) => row && !row.startsWith('#')).map((row) => row.split(' '));
    const file = (i) => (i < COVERED[0] ? rows[i][1] : i >= COVERED[1] ? rows[Math.max(0, COVERED[0] - 1 - (i - COVERED[1]))][1] : list === 'depth.txt' ? 'depth/blank.png' : rows[i][1]);
    writeFileSync(join(path, list), rows.map(([stamp], i) => `${stamp} ${file(i)}\n`).join(''));
  }
  rmSync(join(path, 'groundtruth.txt'), { force: true });
}

before(async () => {
  for (const [name, path] of [['desk', 'orbit'], ['covered', 'handheld']])
    execFileSync(program, ['simulate', '--scene', 'desk', '--trajectory', path, '--size', '160x120', '--frames', String(FRAMES), '-o', join(folder, name), '--quiet']);
  cover(join(folder, 'covered'));
  browser = await launch();
});

after(async () => {
  await browser?.close();
  for (const run of running) run.kill('SIGKILL');
  rmSync(folder, { recursive: true, force: true });
});

test('a recording: it grows, stands still, goes back, is cropped and finished', { timeout: 280_000 }, async (t) => {
  const out = join(folder, 'out');
  const run = start('run', join(folder, 'desk'), '-o', out, '--view', '--realtime', '--speed', '0.1', ...SMALL.slice(0, -1));
  const { page, complaints, close } = await open(run);

  await t.test('the surface grows', async () => {
    await until(page, () => window.plumbline.state.frame && window.plumbline.viewer.surface.triangles > 2000);
    const before = await count(page);
    const at = (await state(page)).frame.index;
    await until(page, ([n, i]) => window.plumbline.viewer.surface.triangles > 1.05 * n && window.plumbline.state.frame.index > i, [before, at]);
    await until(page, () => window.plumbline.state.frame.index > 30); // enough for half a second to be undone
    assert.ok((await look(page)).filled > 0.05);
    await until(page, () => window.plumbline.viewer.camera.position.distanceTo(window.plumbline.viewer.marker.position) < 2.2); // it follows
    const { frame, up, rate } = await state(page);
    assert.equal(frame.status, 'tracked');
    assert.ok(Math.abs(Math.hypot(...up) - 1) < 1e-6 && rate > 0);
  });

  await t.test('shows what the camera sees', async () => {
    await until(page, () => ['color', 'depth'].every((id) => document.getElementById(id).querySelector('canvas').width === 160));
  });

  await t.test('Space lets it stand still', async () => {
    await page.keyboard.press('Space');
    await until(page, () => window.plumbline.state.phase === 'paused');
    assert.equal(await page.textContent('#status'), 'Paused');
    const { frames } = await state(page);
    await page.waitForTimeout(700);
    assert.equal((await state(page)).frames, frames);
  });

  await t.test('undo takes the latest seconds back', async () => {
    const before = await state(page);
    await page.evaluate(() => window.plumbline.link.send('undo', { seconds: 0.5 }));
    await until(page, (i) => window.plumbline.state.phase === 'paused' && window.plumbline.state.frame?.index < i, before.frame.index);
    const { frame } = await state(page);
    assert.ok(before.frame.time - frame.time > 0.499 && before.frame.time - frame.time < 1.2, `${before.frame.time} to ${frame.time}`);
    await until(page, grown);
    assert.ok(await page.evaluate(() => window.plumbline.viewer.path.length) > 0);
  });

  await t.test('it goes on from there', async () => {
    const { frame } = await state(page);
    await page.click('#go');
    await until(page, (i) => window.plumbline.state.phase === 'running' && window.plumbline.state.frame.index > i, frame.index);
    await page.click('#go');
    await until(page, () => window.plumbline.state.phase === 'paused');
  });

  await t.test('while it stands still all is drawn, and as much as there is time for when it goes on', async () => {
    const rested = () => {
      const { viewer } = window.plumbline;
      const seen = [...viewer.surface.regions.values()].filter(({ sphere }) => viewer.surface.frustum.intersectsSphere(sphere));
      return viewer.resolution === 1 && viewer.surface.drawn > 0 && viewer.surface.drawn === seen.reduce((sum, { triangles }) => sum + triangles[0], 0);
    };
    assert.equal(await page.evaluate(() => document.body.classList.contains('slow')), true);
    await until(page, rested);
    const { frame } = await state(page);
    await page.click('#go');
    await until(page, (i) => window.plumbline.state.frame.index > i && window.plumbline.viewer.resolution < 1, frame.index);
    await page.click('#go');
    await until(page, () => window.plumbline.state.phase === 'paused');
    await until(page, rested);
  });

  await t.test('a page that draws slowly gets the newest, and nothing piles up', async () => {
    await page.evaluate(() => {
      const { viewer } = window.plumbline;
      window.shown = [];
      viewer.show = (onDrawn) => {
        window.shown.push(window.plumbline.state.frame.index);
        setTimeout(() => Object.getPrototypeOf(viewer).show.call(viewer, onDrawn), 1200);
      };
    });
    await page.click('#go');
    await until(page, () => window.shown.length > 4);
    const { shown, maxUnshown, missing } = await page.evaluate(() => ({ shown: window.shown, maxUnshown: window.plumbline.maxUnshown, missing: window.plumbline.link.socket.bufferedAmount }));
    assert.equal(maxUnshown, 1);
    assert.equal(missing, 0);
    assert.ok(shown.at(-1) - shown[1] >= 2 * (shown.length - 2), `frames are left out: ${shown}`);
    await page.evaluate(() => delete window.plumbline.viewer.show);
    await page.click('#go');
    await until(page, () => window.plumbline.state.phase === 'paused');
  });

  await t.test('three ways to look at it', async () => {
    const looks = [];
    for (const key of ['1', '2', '3']) {
      await page.keyboard.press(key);
      looks.push((await look(page)).colors);
    }
    assert.equal(await page.isVisible('#seen-legend'), true);
    assert.ok(looks[0] > looks[1], `colour has ${looks[0]} shades, clay ${looks[1]}`);
    for (const key of ['a', 'e', 'f']) await page.keyboard.press(key);
    assert.equal(await page.evaluate(() => window.plumbline.viewer.mode), 'follow');
  });

  let kept;
  await t.test('a box is kept', async () => {
    await page.keyboard.press('c');
    await page.locator('#crop-panel').waitFor();
    await page.locator('#crop-panel input[aria-label=Right]').focus();
    for (let i = 0; i < 20; i++) await page.keyboard.press('ArrowLeft');
    await page.click('text=Keep the box');
    await until(page, () => window.plumbline.state.crop);
    kept = (await state(page)).crop;
    assert.ok(kept.size.every((x) => x > 0));
  });

  await t.test('finished, the page is the report', async () => {
    await page.click('#finish');
    await page.click('text=Finish and save');
    await page.waitForURL(/report\.html/);
    await until(page, () => Boolean(window.plumbline?.report));
    assert.match(await page.textContent('#remarks'), /Of the surface a box of/);
    assert.equal(await run.done, 0);
    const mesh = await page.evaluate(() => {
      const { mesh } = window.plumbline.report;
      return Array.from({ length: mesh.vertices }, (_, i) => [0, 1, 2].map((k) => mesh.origin[k] + mesh.step * mesh.positions[4 * i + k]));
    });
    const [x, y, z, w] = kept.turn;
    const inside = mesh.every((p) => {
      const [a, b, c] = p.map((value, k) => value - kept.middle[k]);
      const [tx, ty, tz] = [2 * (b * z - c * y), 2 * (c * x - a * z), 2 * (a * y - b * x)]; // by the inverse turn
      const q = [a + w * tx + (ty * z - tz * y), b + w * ty + (tz * x - tx * z), c + w * tz + (tx * y - ty * x)];
      return q.every((value, k) => Math.abs(value) <= kept.size[k] / 2 + 1e-3);
    });
    assert.ok(mesh.length > 100 && inside);
    for (const name of ['trajectory.txt', 'mesh.ply', 'frames.csv', 'summary.json']) assert.ok(existsSync(join(out, name)), name);
  });

  assert.deepEqual(complaints, []);
  await close();
});

test('a loss is guided, and found again', { timeout: 280_000 }, async () => {
  const run = start('run', join(folder, 'covered'), '-o', join(folder, 'out-covered'), '--view', '--realtime', '--speed', '0.25', '--detail', 'off', '--no-color');
  const { page, complaints, close } = await open(run);
  await until(page, () => window.plumbline.state.frame?.status === 'lost');
  await until(page, () => document.getElementById('hint').dataset.kind === 'back');
  assert.match(await page.textContent('#hint'), /Turn back here/);
  await page.locator('#good canvas').waitFor();
  const ghost = await page.evaluate(() => ({ isLost: window.plumbline.viewer.isLost, at: window.plumbline.viewer.marker.position.toArray(), path: window.plumbline.viewer.path.slice(-3) }));
  assert.equal(ghost.isLost, true);
  assert.ok(Math.hypot(...ghost.at.map((x, k) => x - ghost.path[k])) < 0.2, 'the ghost stands where the camera was still tracked');
  await until(page, () => window.plumbline.state.frame.status === 'tracked');
  await until(page, () => document.getElementById('good').hidden && document.getElementById('hint').dataset.kind !== 'back');
  run.kill('SIGINT');
  assert.equal(await run.done, 130);
  assert.deepEqual(complaints.filter((text) => !/WebSocket|report\.html/.test(text)), []);
  await close();
});

test('two pages, one closed and opened again', { timeout: 280_000 }, async () => {
  const run = start('run', join(folder, 'desk'), '-o', join(folder, 'out-two'), '--view', '--realtime', '--speed', '0.1', ...SMALL);
  const first = await open(run);
  await until(first.page, grown);
  const second = await open(run, { viewport: { width: 390, height: 800 }, colorScheme: 'dark' });
  await until(second.page, grown);
  assert.equal(await second.page.evaluate(() => document.documentElement.scrollWidth), 390);
  await first.close();
  const { frame } = await state(second.page);
  await until(second.page, (i) => window.plumbline.state.frame.index > i, frame.index);
  const again = await open(run);
  await until(again.page, () => window.plumbline.viewer.surface.triangles > 1000 && window.plumbline.viewer.path.length > 30);
  await again.page.click('#go');
  await until(second.page, () => window.plumbline.state.phase === 'paused'); // one steers, both see it
  for (const { complaints } of [first, second, again]) assert.deepEqual(complaints, []);
  await again.page.evaluate(() => window.plumbline.link.send('reset'));
  await until(second.page, () => window.plumbline.state.phase === 'paused' && window.plumbline.state.frame === null && window.plumbline.viewer.surface.triangles === 0);
  run.kill('SIGINT');
  await run.done;
  await again.close();
  await second.close();
});

/** The status that a request with these headers gets. */
function ask(url, path, headers = {}) {
  return new Promise((resolve, reject) => {
    const request = http.request({ host: url.hostname, port: url.port, path, headers, agent: false });
    request.on('response', (response) => {
      response.resume();
      response.on('end', () => resolve(response.statusCode));
    });
    request.on('upgrade', (response, socket) => resolve({ status: response.statusCode, socket }));
    request.on('error', reject);
    request.end();
  });
}

const upgrade = (url, extra = {}) => ({ Connection: 'Upgrade', Upgrade: 'websocket', 'Sec-WebSocket-Version': '13', 'Sec-WebSocket-Key': 'AAAAAAAAAAAAAAAAAAAAAA==', Origin: url.origin, ...extra });

/** A frame as browsers send it, masked by zeros. */
function frame(opcode, payload, length = payload.length) {
  const size = length < 126 ? [0x80 | length] : [0x80 | 126, length >> 8, length & 0xff];
  return Buffer.concat([Buffer.from([0x80 | opcode, ...size, 0, 0, 0, 0]), Buffer.from(payload)]);
}

test('strangers are refused, and nothing stops', { timeout: 280_000 }, async (t) => {
  const run = start('run', join(folder, 'desk'), '-o', join(folder, 'out-strangers'), '--view', '--realtime', '--speed', '0.1', ...SMALL);
  const url = await run.url;
  const good = url.pathname + url.search;
  const wrong = `/?token=${'0'.repeat(32)}`;
  const socket = `/live${url.search}`;

  await t.test('a wrong token, a foreign site, another name', async () => {
    assert.equal(await ask(url, good), 200);
    assert.equal(await ask(url, '/'), 403);
    assert.equal(await ask(url, wrong), 403);
    assert.equal(await ask(url, good, { Origin: 'http://example.org' }), 403);
    assert.equal(await ask(url, good, { Host: `plumbline.example.org:${url.port}` }), 403);
    assert.equal(await ask(url, `/secret${url.search}`), 404);
    assert.equal(await ask(url, `/report.html${url.search}`), 404); // not yet
    assert.equal(await ask(url, socket.replace(/.{4}$/, 'ffff!'), upgrade(url)), 403);
    assert.equal(await ask(url, socket, upgrade(url, { Origin: 'http://example.org' })), 403);
    assert.equal(await ask(url, socket, upgrade(url, { Origin: 'null' })), 403);
    assert.equal(await ask(url, socket, upgrade(url, { Host: 'example.org', Origin: 'http://example.org' })), 403);
    const { Origin, ...without } = upgrade(url);
    assert.equal(await ask(url, socket, without), 403);
  });

  await t.test('garbage on the socket closes it', async () => {
    const garbage = [frame(1, 'no request'), frame(1, '{"do":"undo","seconds":-1}'), frame(1, '{"do":"finish","now":true}'), frame(2, '{"do":"finish"}'),
      frame(1, 'x'.repeat(5000)), frame(9, 'x'.repeat(300)), frame(3, 'reserved'), frame(1, Buffer.from([0xff, 0xfe])), Buffer.from([0x81, 0x05, 1, 2, 3, 4, 5]),
      Buffer.concat([Buffer.from([0x81, 0xff, 0x7f, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff, 0, 0, 0, 0]), Buffer.alloc(64)])];
    for (const bytes of garbage) {
      const answer = await ask(url, socket, upgrade(url));
      assert.equal(answer.status, 101);
      answer.socket.on('error', () => {});
      answer.socket.resume();
      answer.socket.write(bytes);
      await new Promise((resolve) => answer.socket.on('close', resolve));
    }
    const half = await ask(url, socket, upgrade(url)); // a frame whose length does not come
    half.socket.on('error', () => {});
    half.socket.resume();
    half.socket.write(Buffer.from([0xff, 0xff, 0xff, 0xff]));
    halfSaid = new Promise((resolve) => half.socket.on('close', resolve));
    await new Promise((resolve) => {
      const raw = net.connect(url.port, url.hostname, () => raw.write(`GET / HTTP/1.1\r\n${'x: y\r\n'.repeat(5000)}`));
      raw.on('error', () => {});
      raw.resume();
      raw.on('close', resolve);
    });
  });

  await t.test('one that never reads costs nothing', async () => {
    const { socket: idle } = await ask(url, socket, upgrade(url));
    idle.pause();
    const { page, complaints, close } = await open(run);
    await until(page, grown);
    const { frame: at } = await state(page);
    await until(page, (i) => window.plumbline.state.frame.index > i, at.index);
    assert.deepEqual(complaints, []);
    idle.destroy();
    await page.click('#go');
    await until(page, () => window.plumbline.state.phase === 'paused');
    await close();
  });
  stranded = run;
});

test('a camera waits for its start, and its latest frames can be undone', { timeout: 280_000 }, async () => {
  const run = start('run', 'live:', '--depth', `virtual:${join(folder, 'desk')}`, '--speed', '0.1', '-o', join(folder, 'out-live'), '--view', ...SMALL);
  const { page, complaints, close } = await open(run);
  await until(page, () => window.plumbline.state.phase === 'ready' && document.getElementById('depth').querySelector('canvas').width === 160);
  assert.match(await page.textContent('#hint'), /Aim, then start/);
  assert.equal((await state(page)).frames, 0);
  await page.keyboard.press('Space');
  await until(page, () => window.plumbline.state.frames > 15);
  const before = await state(page);
  await page.evaluate(() => window.plumbline.link.send('undo', { seconds: 0.2 }));
  await until(page, (n) => window.plumbline.state.phase === 'paused' && window.plumbline.state.frames < n, before.frames);
  await page.keyboard.press('Space');
  await until(page, () => window.plumbline.state.phase === 'running');
  await page.keyboard.press('Shift+Enter');
  await page.click('text=Finish and save');
  await page.waitForURL(/report\.html/);
  assert.equal(await run.done, 0);
  assert.deepEqual(complaints, []);
  await close();
});

test('a recording being made: images alone, ended by the page', { timeout: 280_000 }, async () => {
  const out = join(folder, 'recorded');
  const run = start('record', '--depth', `virtual:${join(folder, 'desk')}`, '--speed', '0.1', '-o', out, '--view');
  const { page, complaints, close } = await open(run);
  await until(page, () => ['color', 'depth'].every((id) => document.getElementById(id).querySelector('canvas').width === 160));
  assert.equal(await page.textContent('#status'), 'Recording');
  assert.equal(await page.isVisible('#go'), false);
  await until(page, () => window.plumbline.state.frames > 3);
  await page.click('#finish');
  await page.click('text=End it');
  await until(page, () => /The recording lies in/.test(document.getElementById('curtain').textContent));
  assert.equal(await run.done, 0);
  assert.ok(readFileSync(join(out, 'depth.txt'), 'utf8').split('\n').length > 3);
  assert.deepEqual(complaints, []);
  await close();
});

test('what was half said is closed after a while, and a run that stands still can be interrupted', { timeout: 280_000 }, async () => {
  await halfSaid;
  stranded.kill('SIGTERM');
  assert.notEqual(await stranded.done, null, 'it ended by itself');
});

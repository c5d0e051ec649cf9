// What a live page measures in a headless Chromium: `node test/measure_live.mjs URL SECONDS`, for bench/view.py. JSON on
// stdout: milliseconds from the camera's frame to its picture on the page, and pictures a second.
import { launch, openPage, until } from './browser.mjs';

const [url, seconds] = process.argv.slice(2);
const browser = await launch();
const { page } = await openPage(browser, url, () => true);
await until(page, () => window.plumbline.latencies.length > 5);
const count = () => page.evaluate(() => ({ n: window.plumbline.latencies.length, updates: window.plumbline.updates, at: performance.now(), index: window.plumbline.state.frame.index }));
const before = await count();
await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
const now = await count();
const latencies = (await page.evaluate((n) => window.plumbline.latencies.slice(n), before.n)).sort((a, b) => a - b);
const at = (share) => latencies[Math.floor(share * (latencies.length - 1))];
const triangles = await page.evaluate(() => window.plumbline.viewer.surface.triangles);
console.log(JSON.stringify({ median_ms: at(0.5), p90_ms: at(0.9), frames: latencies.length, updates_per_s: (1e3 * (now.updates - before.updates)) / (now.at - before.at), camera_frames: now.index - before.index, triangles }));
await browser.close();

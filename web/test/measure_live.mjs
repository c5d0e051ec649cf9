// What a live page measures in a headless Chromium: `node test/measure_live.mjs URL SECONDS`, for bench/view.py. JSON on
// stdout. A frame's latency runs from its coming out of the camera until its pose, its pictures and what there is of its
// surface are drawn, the drawing is finished (a fence of WebGL) and the browser has begun its next picture; an update is
// a frame that was shown like that. A surface's runs from the frame that brought something new to it.
import { launch, openPage, until } from './browser.mjs';

const [url, seconds] = process.argv.slice(2);
const browser = await launch();
const { page } = await openPage(browser, url, () => true);
await until(page, () => window.plumbline.latencies.length > 5);
const look = () =>
  page.evaluate(() => {
    const { latencies, surfaceLatencies, state, viewer, maxUnshown } = window.plumbline;
    return { frames: latencies.length, surfaces: surfaceLatencies.length, at: performance.now(), index: state.frame.index, triangles: viewer.surface.triangles, drawn: viewer.surface.drawn, resolution: viewer.resolution, pictures: viewer.rendered, maxUnshown };
  });
const before = await look();
await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
const now = await look();
const sorted = (name, from) => page.evaluate(([name, from]) => window.plumbline[name].slice(from).sort((a, b) => a - b), [name, from]);
const frames = await sorted('latencies', before.frames), surfaces = await sorted('surfaceLatencies', before.surfaces);
const at = (values, share) => Math.round(values[Math.floor(share * (values.length - 1))]);
const passed = (now.at - before.at) / 1e3;
const rate = (value) => Number((value / passed).toFixed(1));
console.log(JSON.stringify({
  median_ms: at(frames, 0.5), p90_ms: at(frames, 0.9), updates_per_s: rate(frames.length), camera_frames_per_s: rate(now.index - before.index),
  surface_median_ms: at(surfaces, 0.5), surface_p90_ms: at(surfaces, 0.9), surfaces: surfaces.length,
  triangles: now.triangles, triangles_drawn: now.drawn, resolution: now.resolution, pictures_per_s: rate(now.pictures - before.pictures), max_unshown: now.maxUnshown,
}));
await browser.close();

// What the tests of both pages share: the browser, and a look at what it has drawn.
import { accessSync, constants } from 'node:fs';
import { delimiter, join } from 'node:path';

function findChromium() {
  const folders = (process.env.PATH ?? '').split(delimiter);
  const candidates = ['chromium', 'chromium-browser', 'google-chrome'].flatMap((name) => folders.map((folder) => join(folder, name)));
  return candidates.find((path) => {
    try {
      accessSync(path, constants.X_OK);
      return true;
    } catch {
      return false;
    }
  });
}

const chromium = findChromium();
export const driver = await import('playwright-core').catch(() => null);
if (!chromium || !driver) {
  console.log(`skipped: ${chromium ? 'playwright-core is not installed (npm ci in web/)' : 'there is no chromium (./dev install)'}`);
  process.exit(77);
}

/** Exits with 77, ctest's "skipped", where there is no browser. */
export const launch = () =>
  driver.chromium.launch({
    executablePath: chromium,
    // As Chromium is without a graphics card: WebGL is drawn by SwiftShader, pages are put together by Skia.
    args: ['--no-sandbox', '--enable-unsafe-swiftshader', '--disable-dev-shm-usage', ...(process.env.PLUMBLINE_CHROMIUM_FLAGS ?? '').split(' ').filter(Boolean)],
  });

/** Until a condition holds in the page, which may forbid what playwright's own waiting evaluates there. */
export async function until(page, condition, argument) {
  for (const end = Date.now() + 120_000; Date.now() < end; await new Promise((resolve) => setTimeout(resolve, 50)))
    if (await page.evaluate(condition, argument).catch(() => false)) return;
  throw new Error(`not within two minutes: ${condition} ${JSON.stringify(argument ?? '')}`);
}

/** A page with all that went wrong in it; `mayAsk(url)` says what it may load. */
export async function openPage(browser, url, mayAsk, options = {}) {
  const context = await browser.newContext({ viewport: { width: 1280, height: 860 }, ...options });
  context.setDefaultTimeout(120_000); // a busy machine without a graphics card
  const page = await context.newPage();
  const complaints = [];
  page.on('console', (message) => {
    // Drawing without a graphics card is slow, and Chromium says so.
    if (['error', 'warning'].includes(message.type()) && !/GPU stall|software WebGL|swiftshader/i.test(message.text())) complaints.push(message.text());
  });
  page.on('pageerror', (error) => complaints.push(error.message));
  page.on('request', (request) => {
    if (!mayAsk(request.url())) complaints.push(`asked the network for ${request.url()}`);
  });
  await page.goto(url);
  await until(page, () => Boolean(window.plumbline));
  return { page, complaints, close: () => context.close() };
}

/** Share of the 3D view that is not background, and how many colours it has. */
export const look = (page) =>
  page.evaluate(() => {
    const { viewer } = window.plumbline;
    viewer.draw();
    const gl = viewer.renderer.getContext();
    const { drawingBufferWidth: width, drawingBufferHeight: height } = gl;
    const pixels = new Uint8Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
    const colors = new Map();
    for (let i = 0; i < pixels.length; i += 4) {
      const key = (pixels[i] << 16) | (pixels[i + 1] << 8) | pixels[i + 2];
      colors.set(key, (colors.get(key) ?? 0) + 1);
    }
    const background = viewer.scene.background.getHex();
    return { filled: 1 - (colors.get(background) ?? 0) / (width * height), colors: colors.size, background };
  });

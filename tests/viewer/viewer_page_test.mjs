// The viewer page in headless Chromium, against the real server:
//   viewer_page_test.mjs --server MORPHOGRAPH --modules NODE_MODULES [--url http://…/] [--screenshots FOLDER]
// Each check states a property; the first that fails ends the test with exit code 1. 77 means skipped, with the reason said.
import assert from 'node:assert/strict';
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, readFileSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join, resolve } from 'node:path';
import { parseArgs } from 'node:util';

const { values: options } = parseArgs({
  options: { server: { type: 'string' }, modules: { type: 'string' }, url: { type: 'string' }, screenshots: { type: 'string' } },
});
const browserPath = [process.env.CHROMIUM, '/usr/bin/chromium', '/usr/bin/chromium-browser', '/usr/bin/google-chrome']
  .find((path) => path && existsSync(path));
if (!browserPath) skip('no Chromium was found (set CHROMIUM to its path)');
if (!existsSync(join(options.modules, 'playwright-core'))) skip('playwright-core is not installed');
const { chromium } = createRequire(join(resolve(options.modules), 'package.json'))('playwright-core');

function skip(reason) {
  console.log(`skipped: ${reason}`);
  process.exit(77);
}

/** Starts the server on a free port; resolves with its address once it says where it listens. */
function startServer(program) {
  const child = spawn(program, ['serve', '--host', '127.0.0.1', '--port', '0'], { stdio: ['ignore', 'pipe', 'pipe'] });
  return new Promise((done, fail) => {
    let said = '';
    const hear = (text) => {
      said += text;
      const address = /http:\/\/[\w.:[\]]+:\d+/.exec(said);
      if (address) done({ child, url: `${address[0]}/` });
    };
    child.stdout.on('data', hear);
    child.stderr.on('data', hear);
    child.on('error', fail);
    child.on('exit', (code) => fail(new Error(`the server ended with ${code}: ${said}`)));
    setTimeout(() => fail(new Error(`the server named no address within 20 s: ${said}`)), 20_000).unref();
  });
}

const started = Date.now();
const checks = [];
async function check(property, body) {
  try {
    await body();
  } catch (error) {
    throw new Error(`${property}`, { cause: error });
  }
  checks.push(property);
  console.log(`ok  ${property}  (${((Date.now() - started) / 1000).toFixed(1)} s)`);
}

const server = options.url ? { url: options.url } : await startServer(options.server);
const profile = mkdtempSync(join(tmpdir(), 'morphograph-viewer-'));
let browser;
let failed = false;
try {
  const { models } = await (await fetch(`${server.url}v1/models`)).json();
  await check('the server holds a model', () => assert.ok(models.length > 0, 'the embedded default model is missing'));
  browser = await chromium.launchPersistentContext(profile, {
    executablePath: browserPath,
    viewport: { width: 1000, height: 640 },
    colorScheme: 'light',
    reducedMotion: 'no-preference',
    args: ['--headless=new', '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking',
      '--disable-component-update', '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'],
  });
  await run(browser.pages()[0] ?? await browser.newPage(), server.url);
  console.log(`${checks.length} checks passed in ${((Date.now() - started) / 1000).toFixed(1)} s`);
} catch (error) {
  failed = true;
  console.error('FAILED', error.message, '\n', error.cause ?? error.stack);
} finally {
  await browser?.close();
  server.child?.removeAllListeners('exit');
  server.child?.kill('SIGTERM');
  rmSync(profile, { recursive: true, force: true, maxRetries: 3 });
}
process.exit(failed ? 1 : 0);

function largestMove(before, after) {
  return Math.max(...before.map((joint, i) => Math.hypot(...joint.map((x, axis) => x - after[i][axis]))));
}

async function run(page, url) {
  page.setDefaultTimeout(60_000);  // a busy machine draws in software, beside other tests
  const host = new URL(url).host;
  const trouble = [];
  const foreign = [];
  const posts = [];
  let expectedStatus = 0; // of an answer that Chromium reports as an error on the console
  page.on('console', (message) => {
    const expected = expectedStatus && message.text().includes(`status of ${expectedStatus}`);
    if (['error', 'warning'].includes(message.type()) && !expected && !/GPU stall due to ReadPixels/.test(message.text())) {
      trouble.push(`${message.type()}: ${message.text()}`);
    }
  });
  page.on('pageerror', (error) => trouble.push(`exception: ${error.message}`));
  page.on('request', (request) => {
    const address = new URL(request.url());
    if (address.protocol !== 'blob:' && address.host !== host) foreign.push(request.url());
    if (request.method() === 'POST' && address.pathname === '/v1/clips') posts.push(request.postData());
  });

  const state = () => page.evaluate(() => window.morphograph.state);
  const joints = () => page.evaluate(() => window.morphograph.joints());
  /** Does something that asks for a clip, and waits until that clip is shown. */
  const newClip = async (act, seed) => {
    const before = posts.length;
    await act();
    await page.waitForFunction((wanted) => window.morphograph.state.seed === wanted && !document.querySelector('#request[aria-busy]'), seed);
    assert.ok(posts.length > before, 'no clip was asked for');
    return { state: await state(), request: posts.at(-1) };
  };
  const pause = async () => {
    if ((await state()).playing) await page.click('#play');
    assert.equal((await state()).playing, false);
  };

  const shot = async (name) => {
    if (options.screenshots) await page.screenshot({ path: join(options.screenshots, `${name}.png`) });
  };

  await check('the page arrives under a strict policy', async () => {
    const response = await page.goto(`${url}?seed=1&duration=6`);
    assert.equal(response.status(), 200);
    assert.match(response.headers()['content-security-policy'], /default-src 'self'/);
    assert.doesNotMatch(response.headers()['content-security-policy'], /unsafe|\*|https?:/);
  });

  await check('a clip is asked for and plays by itself', async () => {
    await page.waitForFunction(() => window.morphograph?.state.frames > 1);
    const frame = (await state()).frame;
    await page.waitForFunction((first) => window.morphograph.state.frame > first + 3, frame);
    assert.equal((await state()).playing, true);
  });

  await check('joints are finite and make a person of human height above the floor', async () => {
    const positions = await joints();
    assert.ok(positions.length >= 15, `${positions.length} joints`);
    assert.ok(positions.flat().every(Number.isFinite));
    const heights = positions.map(([, y]) => y);
    const height = Math.max(...heights) - Math.min(...heights);
    assert.ok(height > 1.2 && height < 2.2, `height ${height} m`);
    assert.ok(Math.min(...heights) > -0.15, `lowest joint ${Math.min(...heights)} m`);
  });

  const picture = () => page.evaluate(() => {
    window.morphograph.render();
    const copy = Object.assign(document.createElement('canvas'), { width: 160, height: 90 });
    const context = copy.getContext('2d');
    context.drawImage(document.getElementById('stage'), 0, 0, 160, 90);
    return [...context.getImageData(0, 0, 160, 90).data];
  });
  await check('the canvas shows a picture that changes with time', async () => {
    await pause();
    await page.keyboard.press('Home');
    const first = await picture();
    const firstJoints = await joints();
    const colours = new Set();
    for (let i = 0; i < first.length; i += 4) colours.add((first[i] << 16) | (first[i + 1] << 8) | first[i + 2]);
    assert.ok(colours.size > 30, `${colours.size} colours`);
    for (const key of ['Shift+ArrowRight', 'ArrowRight', 'ArrowRight']) await page.keyboard.press(key);
    assert.equal((await state()).frame, 12);
    const laterJoints = await joints();
    const fromRoot = (all) => all.map((joint) => joint.map((x, axis) => x - all[0][axis]));
    const swung = largestMove(fromRoot(firstJoints), fromRoot(laterJoints));
    assert.ok(swung > 0.1, `no limb moved by more than ${swung} m against the root`);
    const later = await picture();
    const changed = first.filter((value, i) => Math.abs(value - later[i]) > 24).length;
    assert.ok(changed > 60, `${changed} values changed`);
  });

  await check('the time line shows each contact and each step of the report, and scrubs', async () => {
    const { report, frames } = await state();
    assert.ok(report.contacts.length > 4, `${report.contacts.length} contacts`);
    assert.equal(await page.locator('.timeline .left-fill, .timeline .right-fill').count(), report.contacts.length);
    assert.equal(await page.locator('.timeline .step').count(), report.steps.length);
    const box = await page.locator('.timeline-drawing').boundingBox();
    await page.mouse.click(box.x + 46 + (box.width - 58) / 2, box.y + 50); // the middle of the axis
    assert.ok(Math.abs((await state()).frame - (frames - 1) / 2) < 3, `frame ${(await state()).frame} of ${frames}`);
    await page.focus('#scrub');
    await page.keyboard.press('Home');
    assert.equal((await state()).frame, 0);
    await page.keyboard.press('Shift+ArrowRight');
    assert.equal((await state()).frame, 10);
    assert.match(await page.getAttribute('#scrub', 'aria-valuetext'), /of \d+\.\d\d seconds/);
  });

  await check('the graph shows what the model holds and lights the step being played', async () => {
    const graph = await page.evaluate(async () => {
      const { models } = await (await fetch('v1/models')).json();
      return (await fetch(`v1/models/${models[0].name}/graph`)).json();
    });
    const { report } = await state();
    const style = report.style ?? '';
    const own = graph.primitives.map((primitive, i) => ({ ...primitive, i })).filter((primitive) => (primitive.style ?? '') === style);
    const ids = new Set(own.map(({ i }) => i));
    assert.equal(await page.locator('#graph .node').count(), own.length);
    assert.equal(await page.locator('#graph .edge').count(), graph.edges.filter(({ from, to }) => ids.has(from) && ids.has(to)).length);
    for (const at of [0, report.steps.length - 1]) {
      const middle = Math.floor((report.steps[at].from + report.steps[at].to) / 2);
      await page.evaluate((frame) => {
        const slider = document.getElementById('scrub');
        slider.value = frame;
        slider.dispatchEvent(new Event('input'));
      }, middle);
      const lit = await page.locator('#graph .node.current .node-name').allTextContents();
      assert.deepEqual(lit, [report.steps[at].primitive.replaceAll('_', ' ')]);
    }
    await page.locator('#graph .node').first().focus();
    await page.keyboard.press('Enter');
    assert.match(await page.textContent('#graph-details'), /examples/);
  });

  await check('curves and quality numbers have units', async () => {
    await page.waitForFunction(() => document.querySelectorAll('#curves .plot').length >= 4);
    const curves = await page.textContent('#curves');
    for (const text of ['Root speed', 'm/s', 'left ball', 'cm', 'Frame difference']) assert.ok(curves.includes(text), text);
    assert.ok(!/NaN|undefined/.test(curves), curves);
    const quality = await page.textContent('#quality');
    for (const text of ['Foot skate', 'cm/s', 'Contact distance', 'mm', 'Naturalness', 'm⁴']) assert.ok(quality.includes(text), text);
    assert.ok(!/NaN|undefined/.test(quality), quality);
  });

  const poseOf = async () => {
    await page.keyboard.press('Home');
    await page.keyboard.press('Shift+ArrowRight');
    return joints();
  };
  await check('the next seed gives another clip', async () => {
    await page.locator('h1').click();
    const before = await poseOf();
    const { request } = await newClip(() => page.click('#next-seed'), '2');
    assert.match(request, /"seed":2\b/);
    assert.match(request, /"unit":"m"/);
    await page.locator('h1').click();
    const after = await poseOf();
    const moved = largestMove(before, after);
    assert.ok(moved > 0.005, `joints moved by ${moved} m at most`);
    assert.match(page.url(), /seed=2/);
  });

  await check('the largest seed is sent to its last digit', async () => {
    const { request } = await newClip(async () => {
      await page.fill('#seed', '18446744073709551615');
      await page.press('#seed', 'Enter');
    }, '18446744073709551615');
    assert.match(request, /"seed":18446744073709551615\b/);
    await newClip(() => page.click('#next-seed'), '0');
  });

  await check('length in seconds and in steps is what the clip has', async () => {
    const seconds = await newClip(async () => {
      await page.fill('#length', '3.5');
      await page.press('#length', 'Enter');
    }, '0');
    await page.waitForFunction(() => Math.abs(window.morphograph.state.report.duration - 3.5) < 0.2);
    assert.match(seconds.request, /"duration":3.5/);
    await page.selectOption('#length-unit', 'steps');
    await page.fill('#length', '7');
    await page.press('#length', 'Enter');
    await page.waitForFunction(() => window.morphograph.state.report.steps.length === 7);
    assert.match(posts.at(-1), /"steps":7/);
  });

  await check('a style that is chosen is asked for', async () => {
    const styles = await page.locator('#style option').evaluateAll((all) => all.map(({ value }) => value).filter(Boolean));
    if (styles.length === 0) {
      assert.equal(await page.isDisabled('#style'), true);
      return;
    }
    await page.selectOption('#style', styles.at(-1));
    await page.waitForFunction((style) => window.morphograph.state.report.style === style, styles.at(-1));
    assert.ok(posts.at(-1).includes(`"style":${JSON.stringify(styles.at(-1))}`));
  });

  await check('a start and a stop are offered where the model has learned them, and asked for', async () => {
    const known = await page.evaluate(async () => (await (await fetch('v1/models')).json()).models[0].boundaries);
    const able = known.some(({ start_from, end }) => start_from.includes('standing') && end.includes('standing'));
    assert.equal(await page.isVisible('#boundaries'), known.some(({ start_from, end }) => start_from.length > 1 || end.length > 1));
    if (!able) return;
    const shown = (first, last) => page.waitForFunction(([f, l]) => {
      const { steps } = window.morphograph.state.report;
      return f === /first_start$/.test(steps[0].primitive) && l === /_end$/.test(steps.at(-1).primitive);
    }, [first, last]);
    await page.selectOption('#start-from', 'standing');
    await page.selectOption('#end', 'standing');
    await shown(true, true);
    assert.match(posts.at(-1), /"start":\{"from":"standing"\}/);
    assert.match(posts.at(-1), /"end":"standing"/);
    assert.match(page.url(), /from=standing&end=standing/);
    await page.selectOption('#start-from', 'walking');
    await page.selectOption('#end', 'walking');
    await shown(false, false);
    assert.doesNotMatch(posts.at(-1), /"start"|"end"/);
  });

  await check('what the server refuses is said plainly, and the clip stays', async () => {
    const before = (await state()).frames;
    await page.selectOption('#length-unit', 'duration');
    expectedStatus = 422;
    await page.fill('#length', '100000');
    await page.press('#length', 'Enter');
    await page.waitForSelector('#problem:not([hidden])');
    const text = await page.textContent('#problem');
    assert.match(text, /422/);
    assert.match(text, /\/duration/);
    assert.equal(await page.getAttribute('#length', 'aria-invalid'), 'true');
    assert.ok((await state()).frames > 1 && before > 1);
    await page.fill('#length', '4');
    await page.press('#length', 'Enter');
    await page.waitForSelector('#problem[hidden]', { state: 'attached' });
    expectedStatus = 0;
    assert.equal(await page.getAttribute('#length', 'aria-invalid'), null);
  });

  const windowAt = (place) => page.evaluate((at) => window.morphograph.windowAt(at), place);
  const asked = () => JSON.parse(posts.at(-1));
  const settled = () => page.waitForFunction(() => !document.querySelector('#request[aria-busy]'));
  /** Draws on the floor with a pen: through these places, from the first to the last. */
  const draw = async (pen, places) => {
    await page.click(`[data-pen="${pen}"]`);
    await page.evaluate(() => scrollTo(0, 0)); // the whole stage is in sight
    const before = posts.length;
    for (const [i, place] of places.entries()) {
      const [x, y] = await windowAt(place);
      await page.mouse.move(x, y, { steps: i ? 3 : 1 });
      if (i === 0) await page.mouse.down();
    }
    await Promise.all([page.waitForRequest((request) => request.method() === 'POST' && request.url().endsWith('/v1/clips')), page.mouse.up()]);
    await page.waitForFunction((name) => document.querySelector(`[data-pen="${name}"]`).getAttribute('aria-pressed') === 'false', pen);
    assert.equal(posts.length, before + 1, 'a clip is asked for once');
    await settled();
  };
  const near = (a, b, metres) => assert.ok(Math.hypot(...a.map((c, i) => c - b[i])) < metres, `${a} is not near ${b}`);

  await check('a path that is drawn on the floor is walked', async () => {
    await draw('path', [[0, 0], [0.1, 1.2], [0.5, 2.3]]);
    const { path, duration, steps } = asked();
    assert.ok(path.points.length >= 5 && path.interpolation === 'spline', JSON.stringify(path));
    near(path.points[0], [0, 0], 0.05);
    near(path.points.at(-1), [0.5, 2.3], 0.05);
    assert.equal(duration ?? steps, undefined); // the way takes its time
    const { report } = await state();
    near(report.path[0], [0, 0], 0.2);
    near(report.path.at(-1), [0.5, 2.3], 0.3);
    assert.equal(await page.locator('#controls li[data-kind="path"]').count(), 1);
    assert.equal(await page.isVisible('#problem'), false, await page.textContent('#problem'));
    assert.match(await page.textContent('#controls .outcome'), /cm off/);
    await shot('path');
  });

  await check('a goal, a hand target and an area to keep out of are drawn too', async () => {
    await draw('goal', [[0.5, 2.3], [0.6, 2.6]]);
    near(asked().goal.position, [0.5, 2.3], 0.05);
    assert.ok(Math.abs(asked().goal.heading - 18) < 6, `${asked().goal.heading}`);
    await draw('keep_out', [[1.6, 0.4], [1.6, 0.8]]);
    assert.equal(await page.isVisible('#problem'), false, await page.textContent('#problem'));
    assert.equal(asked().constraints.length, 1);
    near(asked().constraints[0].circle.center, [1.6, 0.4], 0.05);
    assert.ok(Math.abs(asked().constraints[0].circle.radius - 0.4) < 0.05);
    const linked = page.url();
    await page.goto(linked);
    await page.waitForFunction(() => window.morphograph?.state.frames > 1 && window.morphograph.state.controls.length === 3);
    assert.equal(asked().constraints.length, 1); // what was drawn stands in the address
    await pause();
    await page.click('#controls li[data-kind="goal"] button');
    await settled();
    assert.equal(asked().goal, undefined);
    expectedStatus = 422; // while its height and time are typed, it may be out of reach
    await draw('hand', [[0.3, 1]]);
    assert.equal(asked().constraints[1].joint, 'right_wrist');
    await page.fill('#controls input[aria-label="Time, s"]', '1');
    await page.fill('#controls input[aria-label="Height, m"]', '1.05');
    await page.press('#controls input[aria-label="Height, m"]', 'Enter');
    await settled();
    near(asked().constraints[1].value, [0.3, 1.05, 1], 0.06);
    assert.equal(asked().constraints[1].time, 1);
    await page.click('#controls li[data-kind="hand"] button');
    await settled();
    expectedStatus = 0;
  });

  await check('variants walk along as ghosts, and what they have in common is said', async () => {
    await page.fill('#variant-count', '5');
    await page.click('#show-variants');
    await page.waitForSelector('#hide-variants:not([hidden])');
    const text = await page.textContent('#variant-summary');
    const made = Number(/^(\d+)( of \d+)? variants/.exec(text)?.[1]);
    assert.ok(made >= 1 && made <= 5, text);
    assert.equal((await state()).ghosts, made);
    for (const part of ['there after', 'from the path', 'm² of floor']) assert.ok(text.includes(part), text);
    await page.evaluate(() => scrollTo(0, 0));
    await page.locator('h1').click();
    for (let i = 0; i < 3; ++i) await page.keyboard.press('Shift+ArrowRight');
    const seen = await picture();
    await shot('variants');
    await page.click('#hide-variants');
    assert.equal((await state()).ghosts, 0);
    const without = await picture();
    assert.ok(seen.filter((value, i) => Math.abs(value - without[i]) > 24).length > 60, 'ghosts cannot be seen');
  });

  await check('what cannot be met is said beside what was drawn', async () => {
    expectedStatus = 422;
    await draw('keep_out', [[0.5, 2.3], [0.5, 2.7]]); // where the path ends
    await page.waitForSelector('#problem:not([hidden])');
    assert.match(await page.textContent('#controls li[data-kind="path"] .field-error'), /kept out of/);
    await shot('unmet');
    expectedStatus = 0;
    await page.click('#clear-controls');
    await page.waitForSelector('#problem[hidden]', { state: 'attached' });
    await settled();
    assert.equal(asked().path, undefined);
    assert.equal(asked().duration, 8);
    assert.equal(await page.locator('#controls li').count(), 0);
    await page.click('[data-view="corner"]');
  });

  await check('the BVH that is saved is the server’s own text in the source unit', async () => {
    const [download] = await Promise.all([page.waitForEvent('download'), page.click('#save-bvh')]);
    assert.match(download.suggestedFilename(), /\.bvh$/);
    const saved = readFileSync(await download.path(), 'utf8');
    assert.match(saved, /^HIERARCHY\s/);
    const { output, ...request } = JSON.parse(posts.at(-1));
    assert.equal(output.unit, 'source');
    const again = await page.evaluate(async (body) =>
      (await fetch('v1/clips', { method: 'POST', headers: { 'Content-Type': 'application/json' }, body })).text(), JSON.stringify(request));
    assert.equal(saved, again);
    const [report] = await Promise.all([page.waitForEvent('download'), page.click('#save-report')]);
    assert.equal(JSON.parse(readFileSync(await report.path(), 'utf8')).frames, (await state()).frames);
  });

  await check('every control has a name', async () => {
    const nameless = await page.evaluate(() => [...document.querySelectorAll('button, input, select')]
      .filter((e) => !(e.getAttribute('aria-label') || e.labels?.[0]?.textContent.trim() || e.textContent.trim()))
      .map((e) => e.outerHTML.slice(0, 120)));
    assert.deepEqual(nameless, []);
  });

  await check('keys play and pause; dark and a phone’s width work', async () => {
    await page.locator('h1').click();
    await page.keyboard.press(' ');
    assert.equal((await state()).playing, true);
    await page.keyboard.press(' ');
    assert.equal((await state()).playing, false);
    const background = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await background();
    await page.click('#theme');
    assert.notEqual(await background(), light);
    await page.setViewportSize({ width: 390, height: 844 });
    await page.waitForFunction(() => document.documentElement.scrollWidth <= 390);
  });

  await check('no trouble on the console, and no other host was asked', async () => {
    assert.deepEqual(trouble, []);
    assert.deepEqual(foreign, []);
  });
}

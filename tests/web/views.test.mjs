// Every view at both widths in both themes: something is drawn, nothing is cut off or covered, no console errors.
// The pictures are kept in build/web-pictures/views/.
import assert from 'node:assert/strict';
import { mkdirSync } from 'node:fs';
import { after, test } from 'node:test';
import { coarse, difference, messages, open, pictures, pixels, prepared, shut, sliced } from './page.mjs';

after(shut);
const folder = `${pictures}views/`;
mkdirSync(folder, { recursive: true });

/** Views with what is chosen in them: the option of a list, or a box that is ticked. */
const SHOWN = [
  { name: 'part', view: 'Part' },
  { name: 'mesh-cut', view: 'Mesh', choose: { Cut: 'Across y' } },
  { name: 'stress', view: 'Stress', choose: { Colour: 'Tension', Cut: 'No cut' } },
  { name: 'critical', view: 'Stress', choose: { Colour: 'Critical region' } },
  { name: 'shape', view: 'Shape', slide: { Deformed: '1' } },
  { name: 'field-arrows', view: 'Field', choose: { Colour: 'Height field', Cut: 'Across y' }, tick: { 'Print directions': true } },
  { name: 'field-tilt', view: 'Field', choose: { Colour: 'Tilt', Cut: 'No cut' }, tick: { 'Print directions': false } },
  { name: 'overhang', view: 'Field', choose: { Colour: 'Overhang' } },
  { name: 'stairs', view: 'Field', choose: { Colour: 'Stair-steps' } },
  { name: 'gouging', view: 'Field', choose: { Colour: 'Gouging' } },
  { name: 'layers', view: 'Layers', choose: { Colour: 'Layer' } },
  { name: 'thickness', view: 'Layers', choose: { Colour: 'Thickness' } },
  { name: 'exploded', view: 'Layers', choose: { Colour: 'Tilt' }, slide: { Explode: '0.6' } },
  { name: 'toolpaths', view: 'Toolpaths', choose: { Colour: 'Kind' }, slide: { Explode: '0' } },
  { name: 'speed', view: 'Toolpaths', choose: { Colour: 'Speed' } },
];

/** Chooses the view and what is in it, as far as its controls are there. */
async function present(page, { view, choose = {}, tick = {}, slide = {} }) {
  await page.getByRole('radio', { name: view, exact: true }).click();
  await page.waitForFunction((name) => document.querySelector('#views [aria-checked=true]')?.textContent === name && !window.s3.workspace.loading, view);
  const display = page.locator('#display');
  // On a narrow screen the options are folded away, and again for the picture.
  const fold = display.locator('.fold');
  const folded = await fold.isVisible();
  if (folded) await fold.click();
  for (const [label, option] of Object.entries(choose)) await display.getByLabel(label).selectOption({ label: option });
  for (const [label, wanted] of Object.entries(tick)) await display.getByLabel(label).setChecked(wanted);
  for (const [label, value] of Object.entries(slide)) {
    const slider = display.getByLabel(label);
    if (await slider.count() > 0) await slider.fill(value);
  }
  if (!folded) return;
  assert.deepEqual(await misplaced(page), [], `${view}, unfolded`);
  await fold.click();
}

/** The view without what it shows: background, plate and axes. */
async function emptied(page) {
  const hidden = await page.evaluateHandle(() => {
    const found = window.s3.workspace.viewer.scene.children.filter((child) => {
      let holds = false;
      child.traverse((one) => { holds ||= Boolean(one.isMesh); });
      return child.visible && holds;
    });
    for (const one of found) one.visible = false;
    return found;
  });
  const empty = await pixels(page);
  await hidden.evaluate((found) => { for (const one of found) one.visible = true; });
  return empty;
}

/** Overlays that overlap each other, stick out of the viewport, or cut off their own text. */
const misplaced = (page) => page.evaluate(() => {
  const problems = [];
  const frame = document.querySelector('.viewport').getBoundingClientRect();
  const boxes = ['views', 'display', 'legend', 'timeline'].map((id) => document.getElementById(id)).filter((element) => element.childElementCount > 0 && !element.hidden)
    .map((element) => ({ id: element.id, box: element.getBoundingClientRect() }));
  for (const { id, box } of boxes) {
    if (box.left < frame.left - 1 || box.right > frame.right + 1 || box.top < frame.top - 1 || box.bottom > frame.bottom + 1) problems.push(`${id} sticks out`);
  }
  // The row of views is as wide as the viewport, its buttons are not.
  const solid = boxes.map(({ id, box }) => ({ id, box: id === 'views' ? document.querySelector('#views .segmented').getBoundingClientRect() : box }));
  solid.forEach((a, i) => solid.slice(i + 1).forEach((b) => {
    if (Math.min(a.box.right, b.box.right) > Math.max(a.box.left, b.box.left) + 1 && Math.min(a.box.bottom, b.box.bottom) > Math.max(a.box.top, b.box.top) + 1) problems.push(`${a.id} covers ${b.id}`);
  }));
  for (const output of document.querySelectorAll('#timeline output, #display output, #legend *')) {
    const holder = output.closest('#timeline, #display, #legend');
    if (output.getBoundingClientRect().right > holder.getBoundingClientRect().right) problems.push(`sticks out: ${output.textContent}`);
    if (output.scrollWidth > output.clientWidth + 1 && getComputedStyle(output).display !== 'inline') problems.push(`cut off: ${output.textContent}`);
  }
  if (document.documentElement.scrollWidth > innerWidth) problems.push('the page is wider than the window');
  return problems;
});

test('every view shows the part at 1280 and 390 pixels, light and dark', { timeout: 400000 }, async (t) => {
  const { page, complaints, close } = await open();
  try {
    await page.locator('.welcome [data-example="bridge.stl"]').click();
    await prepared(page);
    await page.waitForFunction(() => window.s3.app.settings.files.loads);
    await coarse(page, { 'mesh.target_tets': 2500 });
    await page.click('#slice');
    await sliced(page);
    assert.deepEqual(await messages(page), []);
    await page.waitForTimeout(300);
    // From the first paint to the results; what follows changes the size of the window.
    const shift = await page.evaluate(() => window.layoutShift);
    t.diagnostic(`layout shift ${shift.toFixed(4)}`);
    assert.ok(shift < 0.01, `layout shift ${shift}`);
    for (const [width, height] of [[1280, 800], [390, 844]]) {
      await page.setViewportSize({ width, height });
      for (const theme of ['light', 'dark']) {
        if (theme !== await page.evaluate(() => document.documentElement.dataset.theme)) await page.getByRole('button', { name: 'Dark or light' }).click();
        for (const shown of SHOWN) {
          await present(page, shown);
          await page.evaluate(() => window.s3.workspace.look('iso'));
          const share = difference(await emptied(page), await pixels(page));
          assert.ok(share > 0.02, `${shown.name} at ${width}, ${theme}: ${share} of the picture`);
          assert.deepEqual(await misplaced(page), [], `${shown.name} at ${width}`);
          if (shown.name === 'toolpaths') {
            // A print of days.
            await page.evaluate(() => { document.querySelector('#timeline output:has(.total)').innerHTML = '123 h 45 min<span class="total"> of 123 h 55 min</span>'; });
            assert.deepEqual(await misplaced(page), [], `long times at ${width}`);
          }
          await page.screenshot({ path: `${folder}${shown.name}-${width}-${theme}.png` });
        }
      }
    }
    assert.deepEqual(complaints, []);
  } finally {
    await close();
  }
});

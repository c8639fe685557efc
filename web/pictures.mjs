// Makes the pictures of the README, pictures/*.png, with the built page itself: node web/pictures.mjs [FOLDER]
import { mkdirSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import { serve } from './serve.mjs';

const here = fileURLToPath(new URL('.', import.meta.url));
const folder = process.argv[2] ?? `${here}pictures`;
mkdirSync(folder, { recursive: true });
const server = await serve({ root: `${here}dist`, isolation: true });
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
const page = await browser.newPage({ viewport: { width: 1180, height: 720 }, serviceWorkers: 'block', colorScheme: 'light' });
await page.goto(server.url);
await page.locator('.welcome [data-example="teapot.stl"]').click();
await page.waitForFunction(() => window.s3.app.inspection && !window.s3.app.running, null, { timeout: 120000 });
await page.evaluate(() => window.s3.app.setParams({
  'mesh.target_tets': 25000, 'nozzle.diameter': 1.5, 'objectives.support_free': 0.5, 'objectives.surface_quality': 0.5, 'objectives.gamma': 8,
}));
await page.click('#slice');
await page.waitForFunction(() => !window.s3.app.running && window.s3.app.stages.every((stage) => stage.state === 'done'), null, { timeout: 900000 });

const show = async (view) => {
  await page.getByRole('radio', { name: view, exact: true }).click();
  await page.waitForFunction((name) => document.querySelector('#views [aria-checked=true]')?.textContent === name && !window.s3.workspace.loading, view);
  await page.evaluate(() => window.s3.workspace.look('iso'));
};
const keep = async (name) => {
  await page.mouse.move(600, 20);
  await page.waitForTimeout(400);
  await page.screenshot({ path: `${folder}/${name}.png` });
};
const scrub = (label, share) => page.evaluate(([name, part]) => {
  const slider = document.querySelector(`[aria-label="${name}"]`);
  slider.value = String(Math.round(Number(slider.min) + part * (Number(slider.max) - Number(slider.min))));
  slider.dispatchEvent(new Event('input'));
}, [label, share]);
const theme = () => page.getByRole('button', { name: 'Dark or light' }).click();

await show('Layers');
await keep('layers');
await theme();
await show('Toolpaths');
await scrub('Playhead along the toolpath', 0.62);
await keep('toolpaths');
await theme();
await show('Field');
await page.locator('#display').getByLabel('Cut').selectOption({ label: 'Across y' });
await page.locator('#display').getByLabel('Print directions').check();
await page.evaluate(() => document.querySelector('#panel-results svg.plot')?.scrollIntoView());
await keep('analysis');
await page.setViewportSize({ width: 390, height: 844 });
await theme();
await show('Toolpaths');
await page.getByRole('tab', { name: 'Goals' }).click();
await keep('narrow');
await browser.close();
await server.close();

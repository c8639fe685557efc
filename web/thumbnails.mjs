// Makes the pictures of the examples, public/examples/*.webp, with the built page itself: node web/thumbnails.mjs
import { mkdirSync, readdirSync, writeFileSync } from 'node:fs';
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import { serve } from './serve.mjs';

const here = fileURLToPath(new URL('.', import.meta.url));
const server = await serve({ root: `${here}dist`, isolation: false });
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'] });
const page = await browser.newPage({ viewport: { width: 1148, height: 644 }, serviceWorkers: 'block' });
await page.goto(server.url);
mkdirSync(`${here}public/examples`, { recursive: true });
for (const file of readdirSync(`${here}../models`).filter((name) => name.endsWith('.stl'))) {
  await page.locator('#file-input').setInputFiles(`${here}../models/${file}`);
  await page.waitForFunction((name) => window.s3.app.model?.file.name === name && window.s3.app.inspection && !window.s3.app.running, file, { timeout: 120000 });
  const webp = await page.evaluate(async () => {
    const { viewer } = window.s3.workspace;
    viewer.scene.background = null;
    // The plate's lines are all that is not a mesh.
    viewer.scene.traverse((object) => { if (object.isLineSegments) object.visible = false; });
    viewer.look('iso');
    const picture = await createImageBitmap(await viewer.picture());
    const canvas = new OffscreenCanvas(216, 162);
    const height = picture.height, width = (height * 4) / 3;
    canvas.getContext('2d').drawImage(picture, (picture.width - width) / 2, 0, width, height, 0, 0, 216, 162);
    return [...new Uint8Array(await (await canvas.convertToBlob({ type: 'image/webp', quality: 0.85 })).arrayBuffer())];
  });
  writeFileSync(`${here}public/examples/${file.replace('.stl', '.webp')}`, Buffer.from(webp));
}
await browser.close();
await server.close();

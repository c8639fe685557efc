// A small static server for the built page: node web/serve.mjs [--port N] [--root DIR] [--no-isolation]
import { createReadStream } from 'node:fs';
import { stat } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, normalize, sep } from 'node:path';
import { fileURLToPath } from 'node:url';
import { createGzip } from 'node:zlib';

const TYPES = {
  '.html': 'text/html; charset=utf-8', '.js': 'text/javascript', '.mjs': 'text/javascript', '.css': 'text/css', '.wasm': 'application/wasm',
  '.json': 'application/json', '.webp': 'image/webp', '.svg': 'image/svg+xml', '.gz': 'application/octet-stream',
};
const PACKED = new Set(['.html', '.js', '.mjs', '.css', '.wasm', '.json']);

/**
 * Serves a folder on the loopback address.
 * @param {{ root: string, port?: number, isolation?: boolean }} options  isolation: send the headers that threads need
 * @returns {Promise<{ url: string, close(): Promise<void> }>}
 */
export async function serve({ root, port = 0, isolation = true }) {
  const server = createServer(async (request, response) => {
    const path = decodeURIComponent(new URL(request.url ?? '/', 'http://localhost').pathname);
    const file = normalize(join(root, path.endsWith('/') ? `${path}index.html` : path));
    const info = file.startsWith(normalize(root) + sep) ? await stat(file).catch(() => null) : null;
    if (!info?.isFile()) {
      response.writeHead(404).end('There is no such file.');
      return;
    }
    const type = extname(file), packed = PACKED.has(type) && /\bgzip\b/.test(String(request.headers['accept-encoding'] ?? ''));
    response.writeHead(200, {
      'Content-Type': TYPES[type] ?? 'application/octet-stream',
      'Cache-Control': 'no-cache',
      'Cross-Origin-Resource-Policy': 'same-origin',
      ...(packed ? { 'Content-Encoding': 'gzip' } : { 'Content-Length': info.size }),
      ...(isolation ? { 'Cross-Origin-Opener-Policy': 'same-origin', 'Cross-Origin-Embedder-Policy': 'require-corp' } : {}),
    });
    const stream = createReadStream(file);
    (packed ? stream.pipe(createGzip({ level: 5 })) : stream).pipe(response);
  });
  await new Promise((resolve, reject) => server.once('error', reject).listen(port, '127.0.0.1', resolve));
  const address = server.address();
  return {
    url: `http://localhost:${typeof address === 'object' && address ? address.port : port}/`,
    close: () => new Promise((resolve) => { server.closeAllConnections(); server.close(() => resolve()); }),
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const option = (name, fallback) => (process.argv.includes(name) ? process.argv[process.argv.indexOf(name) + 1] : fallback);
  const { url } = await serve({
    root: option('--root', fileURLToPath(new URL('dist', import.meta.url))), port: Number(option('--port', 8033)), isolation: !process.argv.includes('--no-isolation'),
  });
  console.log(`S³ Slicer is at ${url} (Ctrl-C ends it)`);
}

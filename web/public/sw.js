// Offline use, and cross-origin isolation on hosts that cannot set headers. The build writes VERSION and FILES.
const VERSION = '__VERSION__';
const FILES = __FILES__;
const CACHE = `s3slicer-${VERSION}`;

self.addEventListener('install', (event) => {
  event.waitUntil(caches.open(CACHE).then((cache) => cache.addAll(FILES)).then(() => self.skipWaiting()));
});

self.addEventListener('activate', (event) => {
  event.waitUntil(
    caches.keys()
      .then((names) => Promise.all(names.filter((name) => name.startsWith('s3slicer-') && name !== CACHE).map((name) => caches.delete(name))))
      .then(() => self.clients.claim()),
  );
});

function isolated(response) {
  if (response.status === 0 || response.headers.has('Cross-Origin-Embedder-Policy')) return response;
  const headers = new Headers(response.headers);
  headers.set('Cross-Origin-Embedder-Policy', 'require-corp');
  headers.set('Cross-Origin-Opener-Policy', 'same-origin');
  headers.set('Cross-Origin-Resource-Policy', 'same-origin');
  return new Response(response.body, { status: response.status, statusText: response.statusText, headers });
}

/** Files that are named by their content come from the cache; the page itself from the net while there is one. */
async function answer(request) {
  const cache = await caches.open(CACHE);
  const known = await cache.match(request, { ignoreSearch: true });
  if (known && request.mode !== 'navigate') return isolated(known);
  try {
    const response = await fetch(request);
    if (response.ok && request.mode !== 'navigate') await cache.put(request, response.clone());
    return isolated(response);
  } catch (error) {
    const page = known ?? (request.mode === 'navigate' ? await cache.match('./') : undefined);
    if (page) return isolated(page);
    throw error;
  }
}

// What the page had loaded before there was a service worker.
self.addEventListener('message', (event) => {
  const keep = Array.isArray(event.data?.keep) ? event.data.keep : [];
  event.waitUntil(caches.open(CACHE).then(async (cache) => {
    for (const url of keep) if (!(await cache.match(url))) await cache.add(url);
  }));
});

self.addEventListener('fetch', (event) => {
  const { request } = event;
  if (request.method === 'GET' && new URL(request.url).origin === location.origin) event.respondWith(answer(request));
});

// The service worker keeps the page for use offline, and gives it the two headers that threads need where the host
// cannot send them.

export function registerServiceWorker(mayReload: () => boolean): void {
  if (!('serviceWorker' in navigator) || !window.isSecureContext) return;
  const hadController = navigator.serviceWorker.controller !== null;
  void navigator.serviceWorker.register(new URL('sw.js', document.baseURI)).catch(() => {});
  navigator.serviceWorker.addEventListener('controllerchange', () => {
    // The first visit came without the headers; the next one comes through the worker. Once, and only on an empty page.
    if (hadController || window.crossOriginIsolated || sessionStorage.getItem('isolating') || !mayReload()) return;
    sessionStorage.setItem('isolating', '1');
    location.reload();
  });
}

/** Keeps files for use offline that were loaded past the service worker. */
export function keepForOffline(urls: string[]): void {
  if (!('serviceWorker' in navigator) || !window.isSecureContext) return;
  void navigator.serviceWorker.ready.then((registration) => registration.active?.postMessage({ keep: urls }));
}

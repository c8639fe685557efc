// What went wrong: what, where, what to do.
import type { App } from './app.ts';
import { h, icon, iconButton } from './dom.ts';

export function makeMessages(app: App, host: HTMLElement, mark: (places: [number, number, number][], frame: 'file' | 'rest') => void): void {
  app.on('problem', ({ title, message, hint, places, frame }) => {
    const close = (): void => element.remove();
    const element = h('div', { class: 'message bad' }, icon('warning'),
      h('div', { class: 'body' }, h('b', {}, title), h('span', {}, message), hint && h('span', { class: 'muted' }, hint),
        places.length > 0 && h('button', { class: 'link', type: 'button', onclick: () => mark(places, frame) }, 'Show where')),
      iconButton('close', 'Close', close));
    while (host.childElementCount >= 3) host.firstElementChild!.remove();
    host.append(element);
  });
  app.on('model', () => host.replaceChildren());  // they were about the part before
}

// Tabs and their panels.
import { h, replace } from './dom.ts';

export function makeTabs(tabHost: HTMLElement, panelHost: HTMLElement, names: [id: string, text: string][], onchoose: () => void): {
  panel(id: string): HTMLElement; choose(id: string): void; current(): string;
} {
  let chosen = names[0]![0];
  const buttons = new Map<string, HTMLButtonElement>(), panels = new Map<string, HTMLElement>();
  const show = (): void => {
    for (const [id, button] of buttons) {
      button.setAttribute('aria-selected', String(id === chosen));
      button.tabIndex = id === chosen ? 0 : -1;
      panels.get(id)!.hidden = id !== chosen;
    }
  };
  const choose = (id: string): void => {
    if (id === chosen) return;
    chosen = id;
    panelHost.scrollTop = 0;
    show();
    onchoose();
  };
  for (const [id, text] of names) {
    buttons.set(id, h('button', { type: 'button', role: 'tab', id: `tab-${id}`, 'aria-controls': `panel-${id}`, onclick: () => choose(id) }, text));
    panels.set(id, h('div', { class: id === 'settings' ? '' : 'panel', role: 'tabpanel', id: `panel-${id}`, 'aria-labelledby': `tab-${id}` }));
  }
  tabHost.addEventListener('keydown', (event) => {
    const step = event.key === 'ArrowRight' ? 1 : event.key === 'ArrowLeft' ? -1 : 0;
    if (!step) return;
    const at = names.findIndex(([id]) => id === chosen);
    const next = names[(at + step + names.length) % names.length]![0];
    choose(next);
    buttons.get(next)!.focus();
    event.preventDefault();
    event.stopPropagation();
  });
  replace(tabHost, ...buttons.values());
  replace(panelHost, ...panels.values());
  show();
  return { panel: (id) => panels.get(id)!, choose, current: () => chosen };
}

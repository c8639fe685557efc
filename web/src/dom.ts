// Small helpers for making elements.

type Attributes = Record<string, string | number | boolean | null | undefined | ((event: never) => void)>;
type Child = Node | string | null | undefined | false;

/** An element with attributes, listeners ("onclick") and children. */
export function h<Tag extends keyof HTMLElementTagNameMap>(tag: Tag, attributes: Attributes = {}, ...children: Child[]): HTMLElementTagNameMap[Tag] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') element.addEventListener(name.slice(2), value as EventListener);
    else if (value === true) element.setAttribute(name, '');
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, String(value));
  }
  element.append(...children.filter((child): child is Node | string => child !== null && child !== undefined && child !== false));
  return element;
}

export function replace(element: Element, ...children: Child[]): void {
  element.replaceChildren(...children.filter((child): child is Node | string => child !== null && child !== undefined && child !== false));
}

/** Line icons on a grid of 16. */
const ICONS: Record<string, string> = {
  open: 'M2 12.5V3.5h4l1.5 2H14v7zM2 7h12',
  save: 'M3 2.5h8l2.5 2.5v8.5h-10.5zM5 2.5v4h5v-4M5 13.5v-4h6v4',
  undo: 'M6 3 2.5 6.5 6 10M2.5 6.5h7a4 4 0 0 1 0 8H7',
  redo: 'M10 3l3.5 3.5L10 10M13.5 6.5h-7a4 4 0 0 0 0 8H9',
  sun: 'M8 5.2a2.8 2.8 0 1 1 0 5.6 2.8 2.8 0 0 1 0-5.6M8 1v1.6M8 13.4V15M1 8h1.6M13.4 8H15M3 3l1.2 1.2M11.8 11.8 13 13M13 3l-1.2 1.2M4.2 11.8 3 13',
  moon: 'M13 9.6A5.6 5.6 0 0 1 6.4 3 5.6 5.6 0 1 0 13 9.6z',
  camera: 'M2 5h3l1-1.5h4L11 5h3v8H2zM8 6.6a2.2 2.2 0 1 1 0 4.4 2.2 2.2 0 0 1 0-4.4',
  play: 'M4.5 2.8 13 8l-8.5 5.2z',
  pause: 'M5 3v10M11 3v10',
  fit: 'M2 6V2h4M10 2h4v4M14 10v4h-4M6 14H2v-4',
  close: 'M3.5 3.5l9 9M12.5 3.5l-9 9',
  help: 'M8 1.8a6.2 6.2 0 1 1 0 12.4A6.2 6.2 0 0 1 8 1.8M6.2 6.2a1.8 1.8 0 1 1 2.6 1.7c-.5.3-.8.6-.8 1.3M8 11.6v.1',
  check: 'M3 8.5 6.5 12 13 4.5',
  warning: 'M8 2 15 14H1zM8 6.5v3.5M8 12v.1',
  trash: 'M3 4.5h10M6 4.5V3h4v1.5M4.5 4.5l.6 9h5.8l.6-9',
  add: 'M8 3v10M3 8h10',
  down: 'M8 2.5v8M4.5 7.5 8 11l3.5-3.5M3 13.5h10',
  chevron: 'M5.5 3.5 10 8l-4.5 4.5',
  cube: 'M8 1.8 13.5 5v6L8 14.2 2.5 11V5zM8 8v6.2M8 8 2.5 5M8 8l5.5-3',
};

export function icon(name: keyof typeof ICONS): SVGSVGElement {
  const svg = document.createElementNS('http://www.w3.org/2000/svg', 'svg');
  svg.setAttribute('viewBox', '0 0 16 16');
  svg.setAttribute('class', 'icon');
  svg.setAttribute('aria-hidden', 'true');
  const path = document.createElementNS('http://www.w3.org/2000/svg', 'path');
  path.setAttribute('d', ICONS[name] ?? '');
  svg.append(path);
  return svg;
}

export function iconButton(name: keyof typeof ICONS, label: string, onclick: (event: MouseEvent) => void): HTMLButtonElement {
  return h('button', { class: 'icon-button', type: 'button', 'aria-label': label, title: label, onclick }, icon(name));
}

/** A slider with a label and its value behind it. */
export function slider(options: {
  label: string; min: number; max: number; step: number | 'any'; value: number; show: (value: number) => string;
  oninput: (value: number) => void; onchange?: (value: number) => void;
}): { element: HTMLLabelElement; input: HTMLInputElement; set(value: number): void } {
  const output = h('output', {}, options.show(options.value));
  const input = h('input', { type: 'range', min: options.min, max: options.max, step: options.step, 'aria-label': options.label });
  input.value = String(options.value);
  input.addEventListener('input', () => {
    output.textContent = options.show(input.valueAsNumber);
    options.oninput(input.valueAsNumber);
  });
  input.addEventListener('change', () => options.onchange?.(input.valueAsNumber));
  return {
    element: h('label', { class: 'slider' }, h('span', {}, options.label), input, output),
    input,
    set(value: number) {
      input.value = String(value);
      output.textContent = options.show(value);
    },
  };
}

/** Buttons of which one is chosen. */
export function segmented<Value extends string>(
  label: string, options: readonly { value: Value; text: string; title?: string }[], chosen: Value, onchoose: (value: Value) => void,
): { element: HTMLElement; set(value: Value): void; enable(value: Value, enabled: boolean, title?: string): void } {
  const buttons = new Map<Value, HTMLButtonElement>();
  const element = h('div', { class: 'segmented', role: 'radiogroup', 'aria-label': label });
  const set = (value: Value): void => {
    for (const [one, button] of buttons) {
      button.setAttribute('aria-checked', String(one === value));
      button.tabIndex = one === value ? 0 : -1;
      // In a row that is too narrow for all.
      if (one === value && element.scrollWidth > element.clientWidth) element.scrollLeft = button.offsetLeft - element.clientWidth / 2 + button.offsetWidth / 2;
    }
  };
  for (const { value, text, title } of options) {
    const button = h('button', { type: 'button', role: 'radio', title, 'data-text': text, onclick: () => { set(value); onchoose(value); } }, text);
    buttons.set(value, button);
    element.append(button);
  }
  element.addEventListener('keydown', (event) => {
    const step = event.key === 'ArrowRight' || event.key === 'ArrowDown' ? 1 : event.key === 'ArrowLeft' || event.key === 'ArrowUp' ? -1 : 0;
    if (!step) return;
    const enabled = [...buttons.values()].filter((button) => !button.disabled);
    const at = enabled.indexOf(document.activeElement as HTMLButtonElement);
    const next = enabled[(at + step + enabled.length) % enabled.length];
    next?.focus();
    next?.click();
    event.preventDefault();
    event.stopPropagation();
  });
  set(chosen);
  return {
    element,
    set,
    enable(value, enabled, title) {
      const button = buttons.get(value);
      if (!button) return;
      button.disabled = !enabled;
      if (title !== undefined) button.title = title;
    },
  };
}

/** Hands a file to the browser's downloads. */
export function download(name: string, content: BlobPart, type = 'application/octet-stream'): void {
  const url = URL.createObjectURL(new Blob([content], { type }));
  const link = h('a', { href: url, download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(url), 10000);
}

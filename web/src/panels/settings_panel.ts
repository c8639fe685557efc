// The parameter form, made from the schema at run time.
import type { App } from '../app.ts';
import { h, replace } from '../dom.ts';
import { groupFields, matches, parseValue, rangeText, unitText } from '../settings.ts';
import type { ParamField } from '../settings.ts';
import { number } from '../format.ts';

interface Row {
  field: ParamField;
  element: HTMLElement;
  show(): void;
}

export function makeSettingsPanel(app: App, host: HTMLElement): void {
  const search = h('input', { type: 'search', placeholder: 'Search settings', 'aria-label': 'Search settings' });
  const advanced = h('input', { type: 'checkbox' });
  const changedOnly = h('input', { type: 'checkbox' });
  const body = h('div', { class: 'panel' });
  const empty = h('p', { class: 'muted', hidden: true }, 'No setting has these words.');
  const machine = h('div', { class: 'group' });
  const rows: Row[] = [];
  replace(host, h('div', { class: 'search' }, search,
    h('div', { class: 'row spread' },
      h('label', { class: 'check' }, advanced, 'Advanced'), h('label', { class: 'check' }, changedOnly, 'Changed only'),
      h('button', { class: 'link', type: 'button', onclick: resetAll }, 'Reset all'))), body);

  function resetAll(): void {
    const rotate = app.param<string>('input.rotate');
    app.setParams({ ...Object.fromEntries(app.fields.map((field) => [field.key, field.default])), 'input.rotate': rotate });
  }

  function build(): void {
    rows.length = 0;
    replace(body, ...groupFields(app.fields).map((group) =>
      h('section', { class: 'group', 'data-group': group.title }, h('h2', {}, group.title),
        ...group.fields.map((field) => {
          const row = makeRow(app, field);
          rows.push(row);
          return row.element;
        }),
        group.title === 'Machine' && machine)), empty);
    update();
  }

  function update(): void {
    for (const row of rows) row.show();
    filter();
    showMachine(app, machine);
  }

  function filter(): void {
    let any = false;
    for (const { field, element } of rows) {
      const visible = matches(field, search.value) && (advanced.checked || !field.advanced || search.value !== '') &&
        (!changedOnly.checked || app.settings.params[field.key] !== field.default);
      element.hidden = !visible;
      any ||= visible;
    }
    for (const section of body.querySelectorAll<HTMLElement>('section')) {
      section.hidden = [...section.querySelectorAll<HTMLElement>('.field')].every((element) => element.hidden);
    }
    empty.hidden = any || rows.length === 0;
  }

  for (const input of [search, advanced, changedOnly]) input.addEventListener('input', filter);
  app.on('engine', build);
  app.on('settings', update);
}

function makeRow(app: App, field: ParamField): Row {
  const id = `param-${field.key.replaceAll('.', '-')}`;
  const name = h('span', { class: 'name' }, field.label);
  const problem = h('p', { class: 'problem', id: `${id}-problem`, hidden: true });
  const reset = h('button', { class: 'reset', type: 'button', hidden: true, title: `Back to ${field.default === '' ? 'nothing' : String(field.default)}`,
    'aria-label': `Reset ${field.label}`, onclick: () => app.setParams({ [field.key]: field.default }) }, 'reset');
  const input = makeInput(app, field, id);
  const unit = unitText(field.unit);
  input.addEventListener('change', () => {
    const text = input instanceof HTMLInputElement && input.type === 'checkbox' ? String(input.checked) : input.value;
    const parsed = parseValue(field, text);
    problem.hidden = !('problem' in parsed);
    input.setAttribute('aria-invalid', String('problem' in parsed));
    if ('problem' in parsed) problem.textContent = parsed.problem;
    else app.setParams({ [field.key]: parsed.value });
  });
  const range = rangeText(field);
  const help = `${field.help}${range ? ` Range${range}.` : ''}`;
  const element = h('div', { class: 'field', 'data-key': field.key },
    h('label', { for: id, title: `${field.key}: ${help}` }, name, h('span', { class: 'key' }, field.key, ' ', reset)),
    h('div', { class: `input${unit ? ' has-unit' : ''}` }, input, unit && h('span', { class: 'unit' }, unit)),
    problem, h('p', { class: 'help', id: `${id}-help` }, help));
  return {
    field,
    element,
    show() {
      const value = app.settings.params[field.key] ?? field.default;
      if (input instanceof HTMLInputElement && input.type === 'checkbox') input.checked = value === true;
      else if (document.activeElement !== input || problem.hidden) input.value = String(value);
      if (document.activeElement !== input) {
        problem.hidden = true;
        input.removeAttribute('aria-invalid');
      }
      const changed = value !== field.default;
      name.classList.toggle('changed', changed);
      reset.hidden = !changed;
    },
  };
}

function makeInput(app: App, field: ParamField, id: string): HTMLInputElement | HTMLSelectElement {
  const common = { id, 'aria-describedby': `${id}-help ${id}-problem` };
  const choices = field.key === 'machine' ? app.engine?.machines.map((machine) => machine.name) ?? [] : field.choices;
  if (choices.length > 0) return h('select', common, ...choices.map((choice) => h('option', { value: choice }, choice)));
  if (field.type === 'boolean') return h('input', { ...common, type: 'checkbox' });
  return h('input', { ...common, type: 'text', inputmode: field.type === 'string' ? 'text' : 'decimal', autocomplete: 'off', spellcheck: 'false' });
}

/** What the chosen machine is, and a way to bring one's own. */
function showMachine(app: App, host: HTMLElement): void {
  const name = app.param<string>('machine');
  const own = app.settings.profile;
  const profile = own && own.name === name ? (JSON.parse(own.json) as Record<string, unknown>) : app.engine?.machines.find((one) => one.name === name);
  const facts: [string, string][] = [];
  if (profile) {
    if (profile.kinematics) facts.push(['Kinematics', String(profile.kinematics).replace('_', ' ')]);
    if (typeof profile.max_tilt_deg === 'number') facts.push(['Largest tilt', `${number(profile.max_tilt_deg)}°`]);
    if (typeof profile.head_cone_angle_deg === 'number') facts.push(['Head cone', `${number(profile.head_cone_angle_deg)}°`]);
  }
  const file = h('input', { type: 'file', accept: '.json', hidden: true, 'aria-label': 'Machine profile', onchange: () => void read() });
  const read = async (): Promise<void> => {
    const chosen = file.files?.[0];
    if (!chosen) return;
    try {
      const json = await chosen.text();
      const parsed = JSON.parse(json) as { name?: unknown };
      const title = typeof parsed.name === 'string' && parsed.name !== '' ? parsed.name : chosen.name.replace(/\.json$/i, '');
      app.change({ profile: { name: title, json }, params: { ...app.settings.params, machine: title } });
    } catch {
      app.fail(new Error('The file is no JSON.'), `“${chosen.name}” is no machine profile`);
    }
  };
  const select = document.getElementById('param-machine') as HTMLSelectElement | null;
  if (select && own && ![...select.options].some((option) => option.value === own.name)) select.append(h('option', { value: own.name }, own.name));
  if (select) select.value = name;
  replace(host,
    profile && typeof profile.description === 'string' ? h('p', { class: 'small muted' }, profile.description) : null,
    facts.length > 0 ? h('dl', { class: 'facts small' }, ...facts.flatMap(([key, value]) => [h('dt', {}, key), h('dd', {}, value)])) : null,
    h('div', {}, h('button', { class: 'button', type: 'button', onclick: () => file.click() }, 'Load a machine profile…'), file));
}

// Parameter values by their dotted keys, the schema as a list of fields, presets.
import type { JsonSchema, Params, Step } from '../../wasm/index.js';

export type ParamValue = number | string | boolean;
export type ParamValues = Record<string, ParamValue>;

export interface ParamField {
  key: string;
  label: string;
  unit: string;
  help: string;
  type: 'number' | 'integer' | 'string' | 'boolean';
  default: ParamValue;
  min: number;
  max: number;
  choices: string[];
  stage: Step;
  advanced: boolean;
}

/** Files are given to the slicer by their own controls, not by name. */
const FILE_KEYS = new Set(['model', 'strength.stress_file', 'strength.load_case', 'strength.critical_region', 'objectives.surface_region']);

/** Nested parameters by dotted keys. */
export function flattenParams(params: Params, prefix = ''): ParamValues {
  const flat: ParamValues = {};
  for (const [name, value] of Object.entries(params)) {
    const key = prefix + name;
    if (typeof value === 'object') Object.assign(flat, flattenParams(value, `${key}.`));
    else flat[key] = value;
  }
  for (const key of FILE_KEYS) delete flat[key];
  return flat;
}

/** The leaves of the schema in its order, without the keys that name files. */
export function schemaFields(schema: JsonSchema): ParamField[] {
  const fields: ParamField[] = [];
  for (const leaf of Object.values(schema.properties ?? {})) {
    if (leaf.properties) {
      fields.push(...schemaFields(leaf));
    } else if (leaf.key && !FILE_KEYS.has(leaf.key)) {
      fields.push({
        key: leaf.key,
        label: leaf.title ?? leaf.key,
        unit: leaf.unit ?? '',
        help: leaf.description ?? '',
        type: leaf.type as ParamField['type'],
        default: leaf.default ?? '',
        min: leaf.minimum ?? -Infinity,
        max: leaf.maximum ?? Infinity,
        choices: leaf.enum ?? [],
        stage: leaf.stage ?? 'mesh',
        advanced: leaf['x-advanced'] ?? false,
      });
    }
  }
  return fields;
}

export function defaultsOf(fields: ParamField[]): ParamValues {
  return Object.fromEntries(fields.map((field) => [field.key, field.default]));
}

/** What the text of an input means for a field. */
export function parseValue(field: ParamField, text: string): { value: ParamValue } | { problem: string } {
  if (field.type === 'boolean') return { value: text === 'true' };
  if (field.type === 'string') {
    if (field.choices.length > 0 && !field.choices.includes(text)) return { problem: `One of ${field.choices.join(', ')}` };
    return { value: text };
  }
  const trimmed = text.trim().replace(',', '.');
  const value = Number(trimmed);
  if (trimmed === '' || !Number.isFinite(value)) return { problem: `A number${rangeText(field)}` };
  if (field.type === 'integer' && !Number.isInteger(value)) return { problem: `A whole number${rangeText(field)}` };
  if (value < field.min || value > field.max) return { problem: `Must lie${rangeText(field)}` };
  return { value };
}

/** " from 0 to 90 °", for messages; empty where there is no limit. */
export function rangeText(field: ParamField): string {
  const unit = unitText(field.unit);
  if (Number.isFinite(field.min) && Number.isFinite(field.max)) {
    return ` from ${plain(field.min)} to ${plain(field.max)}${unit ? ` ${unit}` : ''}`;
  }
  if (Number.isFinite(field.min)) return ` of at least ${plain(field.min)}${unit ? ` ${unit}` : ''}`;
  if (Number.isFinite(field.max)) return ` of at most ${plain(field.max)}${unit ? ` ${unit}` : ''}`;
  return '';
}

const plain = (value: number): string => (Math.abs(value) >= 1e4 ? value.toLocaleString('en') : String(value));

export const unitText = (unit: string): string => (unit === 'deg' ? '°' : unit);

/** All words of the query occur in label, key or help. */
export function matches(field: ParamField, query: string): boolean {
  const text = `${field.label} ${field.key} ${field.help}`.toLowerCase();
  return query.toLowerCase().split(/\s+/).every((word) => text.includes(word));
}

export interface FieldGroup {
  title: string;
  fields: ParamField[];
}

const GROUP_TITLES: Record<string, string> = {
  input: 'Model', mesh: 'Volume mesh', strength: 'Stress', objectives: 'Objectives', deform: 'Layer field',
  nozzle: 'Layers', layers: 'Layers', toolpath: 'Toolpaths', machine: 'Machine',
};

/** Fields in the order of the pipeline, those of one kind together. */
export function groupFields(fields: ParamField[]): FieldGroup[] {
  const groups: FieldGroup[] = [];
  for (const field of fields) {
    const prefix = field.key.split('.')[0]!;
    const title = GROUP_TITLES[prefix] ?? prefix;
    let group = groups.find((one) => one.title === title);
    if (!group) groups.push((group = { title, fields: [] }));
    group.fields.push(field);
  }
  return groups;
}

/** Keys whose values differ. */
export function changedKeys(a: ParamValues, b: ParamValues): string[] {
  return [...new Set([...Object.keys(a), ...Object.keys(b)])].filter((key) => a[key] !== b[key]).sort();
}

export interface Preset {
  name: string;
  help: string;
  values: ParamValues;
}

/** What the part should be good at. Strength needs loads. */
export const GOAL_PRESETS: Preset[] = [
  {
    name: 'No supports',
    help: 'Layers bend so that no face overhangs them too far.',
    values: { 'objectives.support_free': 1, 'objectives.strength': 0, 'objectives.surface_quality': 0, 'objectives.gamma': 20 },
  },
  {
    name: 'Smooth surface',
    help: 'Layers also meet the surface flat or upright, without stair-steps.',
    values: { 'objectives.support_free': 0.5, 'objectives.strength': 0, 'objectives.surface_quality': 0.5, 'objectives.gamma': 8 },
  },
  {
    name: 'Strong',
    help: 'Layers and beads run along the tension of your loads.',
    values: { 'objectives.support_free': 0.7, 'objectives.strength': 0.3, 'objectives.surface_quality': 0, 'objectives.gamma': 20 },
  },
];

/** How fine the volume mesh is: the time of a run grows with it. */
export const DETAIL_PRESETS: Preset[] = [
  { name: 'Draft', help: 'Seconds; fine features are simplified.', values: { 'mesh.target_tets': 12000 } },
  { name: 'Standard', help: 'A good start for most parts.', values: { 'mesh.target_tets': 50000 } },
  { name: 'Fine', help: 'Minutes in the browser.', values: { 'mesh.target_tets': 150000 } },
];

export const matchesPreset = (preset: Preset, values: ParamValues): boolean =>
  Object.entries(preset.values).every(([key, value]) => values[key] === value);

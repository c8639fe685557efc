// The range of layers and the playhead that prints along the path.
import { h, icon, replace } from './dom.ts';
import { printTime } from './format.ts';

export interface TimelineContent {
  /** Pieces of layers in print order. */
  count: number;
  describe(from: number, to: number): string;
  waypoints: {
    /** The first waypoint of each piece, and the end: #count+1. */
    begin: Uint32Array;
    speeds: ArrayLike<number>;
    positions: ArrayLike<number>;
    /** s since the start at each waypoint; null where no machine was planned for. */
    times: ArrayLike<number> | null;
  } | null;
}

export interface Timeline {
  show(content: TimelineContent): void;
  hide(): void;
  readonly range: [number, number];
  step(layers: number): void;
  toggle(): void;
}

const SPEEDS = [1, 10, 50, 200, 1000];

export function makeTimeline(host: HTMLElement, events: { onrange(from: number, to: number): void; onplayhead(at: number | null): void }): Timeline {
  let content: TimelineContent | null = null;
  let times: ArrayLike<number> = [];
  let range: [number, number] = [0, 0];
  let playing = 0;
  let clock = 0;       // s of printing
  let speed = 200;

  const low = h('input', { type: 'range', min: 0, step: 1, 'aria-label': 'First piece shown' });
  const high = h('input', { type: 'range', min: 0, step: 1, 'aria-label': 'Last piece shown' });
  const fill = h('div', { class: 'fill' });
  const text = h('output', {});
  const head = h('input', { type: 'range', min: 0, step: 1, 'aria-label': 'Playhead along the toolpath' });
  const time = h('output', {});
  const play = h('button', { class: 'icon-button', type: 'button', 'aria-label': 'Print along the path', title: 'Space', onclick: toggle }, icon('play'));
  const rate = h('select', { 'aria-label': 'Speed of the playhead', onchange: () => { speed = Number(rate.value); } }, ...SPEEDS.map((value) => h('option', { value }, `${value}×`)));
  rate.value = String(speed);
  const line = h('div', { class: 'line' }, h('span', {}, 'Layers'), h('div', { class: 'range' }, fill, low, high), text);
  const print = h('div', { class: 'line' }, play, head, rate, time);
  low.addEventListener('input', () => setRange(Math.min(low.valueAsNumber, high.valueAsNumber - 1), high.valueAsNumber));
  high.addEventListener('input', () => setRange(low.valueAsNumber, Math.max(high.valueAsNumber, low.valueAsNumber + 1)));
  head.addEventListener('input', () => { pause(); setHead(head.valueAsNumber); });

  function setRange(from: number, to: number): void {
    if (!content) return;
    from = Math.max(0, Math.min(from, content.count - 1));
    to = Math.max(from + 1, Math.min(to, content.count));
    range = [from, to];
    low.value = String(from);
    high.value = String(to);
    fill.style.left = `${(100 * from) / content.count}%`;
    fill.style.right = `${100 - (100 * to) / content.count}%`;
    text.textContent = content.describe(from, to);
    pause();
    resetHead();
    events.onrange(from, to);
  }

  function ends(): [number, number] {
    const begin = content?.waypoints?.begin;
    return begin ? [begin[range[0]]!, begin[range[1]]! - 1] : [0, 0];
  }
  function resetHead(): void {
    const [first, last] = ends();
    head.min = String(first);
    head.max = String(Math.max(first, last));
    head.value = head.max;
    clock = times[last] ?? 0;
    showTime(last);
  }
  function showTime(at: number): void {
    replace(time, printTime(times[at] ?? 0), h('span', { class: 'total' }, ` of ${printTime(times[times.length - 1] ?? 0)}`));
  }
  function setHead(at: number): void {
    head.value = String(at);
    clock = times[at] ?? 0;
    showTime(at);
    events.onplayhead(at);
  }
  function pause(): void {
    if (playing) cancelAnimationFrame(playing);
    playing = 0;
    replace(play, icon('play'));
  }
  function toggle(): void {
    if (!content?.waypoints) return;
    if (playing) return pause();
    const [first, last] = ends();
    if (head.valueAsNumber >= last) setHead(first);
    replace(play, icon('pause'));
    let before = performance.now();
    const tick = (now: number): void => {
      clock += (speed * Math.min(100, now - before)) / 1000;
      before = now;
      const at = Math.min(last, firstAfter(times, clock, head.valueAsNumber, last));
      head.value = String(at);
      showTime(at);
      events.onplayhead(at);
      playing = at >= last ? 0 : requestAnimationFrame(tick);
      if (!playing) pause();
    };
    playing = requestAnimationFrame(tick);
  }

  return {
    show(next) {
      pause();
      const same = content !== null && content.count === next.count && range[1] > 0;
      content = next;
      low.max = high.max = String(next.count);
      times = next.waypoints ? (next.waypoints.times ?? estimate(next.waypoints.positions, next.waypoints.speeds)) : [];
      // The text must not move what stands beside it while it counts.
      const longest = printTime(times[times.length - 1] ?? 0).length;
      time.style.setProperty('--reserved', `${2 * longest + 4}ch`);
      time.style.setProperty('--reserved-narrow', `${longest + 1}ch`);
      replace(host, line, next.waypoints && print);
      const [from, to] = same ? range : [0, next.count];
      setRange(from, to);
    },
    hide() {
      pause();
      replace(host);
    },
    get range() {
      return range;
    },
    step(layers) {
      if (!content || host.childElementCount === 0) return;
      setRange(range[0], range[1] + layers);
    },
    toggle,
  };
}

/** The first index from `from` on whose time is not below; times ascend. */
export function firstAfter(times: ArrayLike<number>, clock: number, from: number, last: number): number {
  let low = from, high = last;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle]! < clock) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Times from distances and speeds, where no machine was planned for. */
export function estimate(positions: ArrayLike<number>, speeds: ArrayLike<number>): Float32Array {
  const times = new Float32Array(speeds.length);
  let sum = 0;
  for (let i = 1; i < times.length; ++i) {
    const length = Math.hypot(positions[3 * i]! - positions[3 * i - 3]!, positions[3 * i + 1]! - positions[3 * i - 2]!, positions[3 * i + 2]! - positions[3 * i - 1]!);
    sum += speeds[i]! > 0 ? length / speeds[i]! : 0;
    times[i] = sum;
  }
  return times;
}

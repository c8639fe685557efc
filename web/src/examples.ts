// The bundled models, served beside the page.

export interface Example {
  file: string;
  name: string;
  title: string;
  /** A load case and settings that come with it. */
  job?: string;
}

export const EXAMPLES: Example[] = [
  { file: 'ring.stl', name: 'Ring', title: 'Upright ring: overhangs of every slope' },
  { file: 'teapot.stl', name: 'Teapot', title: 'Spout, handle and knob: branches that join again' },
  { file: 'mushroom.stl', name: 'Mushroom', title: 'One large overhang around a thin stem' },
  { file: 'dome.stl', name: 'Dome', title: 'Free-form top: surface quality' },
  { file: 'bridge.stl', name: 'Bridge', title: 'Arch under a load of 200 N: strength', job: 'bridge.job.json' },
  { file: 'bracket.stl', name: 'Bracket', title: 'Bracket with two load cases: strength', job: 'bracket.job.json' },
  { file: 'trio.stl', name: 'Trio', title: 'Three bodies on one plate' },
];

/** Endings of files that the slicer reads, for file dialogs. */
export const MODEL_TYPES = '.stl,.obj,.ply,.3mf,.off,.tet,.msh,.vtu,.gz,.zip';

// What plot/page.py puts into a page, as page.js sees it.

type PackedArray = Float32Array | Uint8Array | Uint16Array | Uint32Array;

interface Packed {
  at: number;
  type: "f4" | "u1" | "u2" | "u4";
  count: number;
}

interface PackedNumbers extends Packed {
  low: number;
  step: number;
}

interface Shades extends PackedNumbers {
  bounds: [number, number];
  faces?: PackedNumbers; // where faces have colors of their own
}

interface Mesh {
  faces: Packed;
  polygons: Packed | null;
  outlines: Packed | null;
  boundary?: Packed | null; // ends of the edges along it
  solid: number; // how many triangles, the first ones, are not seen through
  cuts?: number; // how often triangles are cut in four, to look as they bend
  own?: Packed | null; // for each vertex, one of the surface's own
}

interface PageSpace {
  curvature: number; // in the unit of the positions
  farthest: number; // radius of a sphere at infinity that is drawn, in radii of the surface
  models: { model: "ambient" | "conformal" | "projective"; name: string }[];
}

interface Frame {
  stage: string;
  t: number | null;
  residual: number | null;
  remarks: string[];
  pause: number; // milliseconds
  mesh: number;
  concave: Packed | null;
  positions: PackedNumbers;
  values: Record<string, Shades>;
}

interface Quantity {
  name: string;
  label: string;
  unit: string;
  scale: "linear" | "log";
  at: "vertices" | "faces";
  ramp?: string[] | null; // its colors, if they are not those of all
}

interface PageData {
  meshes: Mesh[];
  first: number; // the frame that is shown at first
  seams: PackedNumbers | null;
  space?: PageSpace | null;
  pose: { center: number[]; axes: number[][]; size: number };
  alone: string;
  camera: number[];
  ramp: string[];
  quantities: Quantity[];
  frames: Frame[];
}

interface Program {
  made: WebGLProgram;
  at: Record<string, WebGLUniformLocation | null>;
}

interface Lines {
  made: WebGLVertexArrayObject;
  ends: WebGLBuffer;
  count: number;
}

interface Parts {
  surface: Program;
  lines: Program;
  faces: Uint32Array; // of the mesh that is in the buffers
  mantle: { made: WebGLVertexArrayObject; positions: WebGLBuffer; normals: WebGLBuffer; shades: WebGLBuffer; faces: WebGLBuffer };
  mesh: Lines;
  rim: Lines;
  creases: Lines;
  seams: Lines;
}

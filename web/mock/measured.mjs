// What the mock says of measurements: figures that look like those of a volume, by simple formulas.

const figure = (name, value, error, unit) => ({ name, value, ...(error === undefined ? {} : { error }), ...(unit ? { unit } : {}) });
const minus = (a, b) => a.map((v, i) => v - b[i]);

function lengthOf(points) {
  return points.slice(1).reduce((sum, p, i) => sum + Math.hypot(...minus(p, points[i])), 0);
}

function angleOf([a, b, c]) {
  const [u, v] = [minus(a, b), minus(c, b)];
  return (Math.acos(u.reduce((sum, x, i) => sum + x * v[i], 0) / Math.hypot(...u) / Math.hypot(...v)) * 180) / Math.PI;
}

const statistics = () => [figure("count", 18432), figure("min", 12), figure("max", 236), figure("mean", 96.42, undefined), figure("deviation", 41.7), figure("median", 92, 0.5)];
const extent = () => [...statistics(), figure("area", 5121.4, 31.2, "mm^2"), figure("volume", 18544.9, 92.1, "mm^3")];

/** The answer to a question: values of a bell along a profile, two bells in a histogram. */
export function measured(question) {
  const { what, points = [] } = question;
  const bell = (x, at, width) => Math.exp(-(((x - at) / width) ** 2));
  const say = (answer, figures) => ({ answer, notes: [], figures });
  if (what === "distance") return say({ points }, [figure("distance", lengthOf(points), 0.41, "mm")]);
  if (what === "angle") return say({ points }, [figure("angle", angleOf(points), 1.3, "deg")]);
  if (what === "point") return say({ points }, [figure("value", 143.2, 0.8)]);
  if (what === "profile") {
    const length = lengthOf(points);
    const profile = Array.from({ length: 81 }, (_, i) => [(length * i) / 80, 20 + 180 * bell(i, 24, 9) + 120 * bell(i, 56, 12)]);
    return say({ profile, profile_error: profile.map(() => 0.5), unit: "mm", value_unit: "" }, [figure("length", length, 0.41, "mm"), figure("min", 20), figure("mean", 71.3), figure("max", 201.2)]);
  }
  if (what === "histogram") return say({ histogram: { lo: 0, hi: 255, n_bins: 128, counts: Array.from({ length: 128 }, (_, i) => Math.round(5200 * bell(i, 40, 12) + 2600 * bell(i, 88, 18))) } }, statistics());
  if (what === "joint") {
    const counts = Array.from({ length: 48 }, (_, j) => Array.from({ length: 64 }, (_, i) => Math.round(4000 * bell(j, 30 * Math.sin((Math.PI * i) / 64), 5))));
    return say({ joint: { values: [0, 255], gradients: [0, 60], n_values: 64, n_gradients: 48, value_unit: "", gradient_unit: "1/mm", counts } }, statistics());
  }
  return say({}, extent());
}

/**
 * The floors of the page: what may import what.  A folder imports those before it in its list and
 * none after it; a module that lies beside the folders of a list stands above them.  Types count.
 */

/** Of `src`, from the lowest floor to the highest. */
const FLOORS = {
  src: 'common protocol net store cloud tools view engine overlays cameras panels work team example boxes desktop xr checking study',
  'src/net': 'chunk depth',
  'src/cloud': 'points picture',
  'src/panels': 'parts timeline labels importing stage',
  'src/xr': 'drawing input moving panels painting bodies',
  'src/xr/panels': 'pages',
};

/** Tests, and what only they import, may look at everything. */
const TESTS = String.raw`(\.test\.tsx?$|/testing(/|\.ts$))`;

/** @type {import('dependency-cruiser').IConfiguration} */
export default {
  forbidden: [
    { name: 'no-circle', severity: 'error', from: {}, to: { circular: true } },
    { name: 'no-unresolved', severity: 'error', from: {}, to: { couldNotResolve: true } },
    { name: 'tests-above', severity: 'error', from: { pathNot: TESTS }, to: { path: TESTS } },
    ...Object.entries(FLOORS).flatMap(([house, names]) => climbs(house, names.split(' '))),
  ],
  options: {
    doNotFollow: { path: 'node_modules' },
    tsPreCompilationDeps: true,
    tsConfig: { fileName: 'tsconfig.json' },
    enhancedResolveOptions: {
      extensions: ['.ts', '.tsx', '.js'],
      exportsFields: ['exports'],
      conditionNames: ['import', 'types', 'default'],
    },
  },
};

/** A rule for each folder of a house: nothing above it, neither a folder nor a module beside them. */
function climbs(house, folders) {
  return folders.map((name, floor) => {
    const above = folders.slice(floor + 1).map((folder) => `${folder}/`);
    return {
      name: `floors-${house}-${name}`,
      severity: 'error',
      from: { path: `^${house}/${name}/`, pathNot: TESTS },
      to: { path: `^${house}/(${[...above, '[^/]+$'].join('|')})` },
    };
  });
}

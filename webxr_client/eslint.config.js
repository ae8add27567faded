import js from '@eslint/js';
import tseslint from 'typescript-eslint';

/** Longer or more branched than the others, each group for a reason. */
const LONGER = {
  // Loops over points and pixels: a call in their middle would cost more than all the rest.
  loops: ['cloud/points/inside.ts', 'cloud/points/pick.ts', 'net/depth/decode.ts'],
  // One decision of a picture or an event, whose steps depend on one another.
  decisions: [
    'panels/labels/label-rows.ts',
    'tools/object.ts',
    'xr/bodies/body.ts',
    'xr/drawing/ui.ts',
    'xr/input/{pointer,pressure}.ts',
    'xr/moving/locomotion.ts',
    'xr/painting/brush-look.ts',
    'xr/panels/room-panels.ts',
  ],
  // Tables: what tests may look at, and markup.
  tables: ['**/hook.ts', '**/*.tsx'],
};

export default tseslint.config(
  { ignores: ['node_modules', 'dist', 'assembly'] },
  js.configs.recommended,
  tseslint.configs.strictTypeChecked,
  {
    languageOptions: {
      parserOptions: {
        projectService: { allowDefaultProject: ['*.config.js', '.dependency-cruiser.js'] },
      },
    },
    rules: {
      '@typescript-eslint/restrict-template-expressions': ['error', { allowNumber: true }],
      '@typescript-eslint/no-confusing-void-expression': ['error', { ignoreArrowShorthand: true }],
      // Fixed-length arrays in hot loops are indexed inside their bounds.
      '@typescript-eslint/no-non-null-assertion': 'off',
    },
  },
  {
    files: ['src/**'],
    ignores: ['**/*.test.*', '**/testing/**', '**/testing.ts', 'src/protocol/{messages,values}.ts'],
    rules: {
      complexity: ['error', 12],
      'max-lines': ['error', 400],
      'max-lines-per-function': ['error', 50],
    },
  },
  {
    files: [...LONGER.loops, ...LONGER.decisions].map((file) => `src/${file}`),
    rules: { complexity: ['error', 20] },
  },
  {
    files: [...LONGER.loops, ...LONGER.tables].map((file) => `src/${file}`),
    rules: { 'max-lines-per-function': ['error', 120] },
  },
  { files: ['*.js', '.*.js'], extends: [tseslint.configs.disableTypeChecked] },
);

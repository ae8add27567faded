import { cp, readFile, writeFile } from 'node:fs/promises';
import { basename, join } from 'node:path';
import { promisify } from 'node:util';
import { brotliCompress, constants, gzip } from 'node:zlib';
import type { Plugin } from 'vite';
import { defineConfig } from 'vitest/config';

const COMPRESSED = /\.(js|css|svg|html)$/;
const LEAST_BYTES = 1024;

const ASSEMBLY = '?assembly';
/** Its own types declare arrays anew, for the page as well. */
const COMPILER: string = 'assemblyscript/asc';

interface Compiler {
  readonly compileString: (
    sources: Record<string, string>,
    options: Record<string, unknown>,
  ) => Promise<{ binary: Uint8Array | null; stderr: { toString(): string } }>;
}

/** Compiles AssemblyScript: `import code from 'x.ts?assembly'` is a WebAssembly module in base64. */
function assembly(): Plugin {
  return {
    name: 'assembly',
    enforce: 'pre',
    async load(id) {
      if (!id.endsWith(ASSEMBLY)) return null;
      const path = id.slice(0, -ASSEMBLY.length);
      this.addWatchFile(path);
      const source = { [basename(path)]: await readFile(path, 'utf8') };
      const options = { optimizeLevel: 3, runtime: 'stub', importMemory: true };
      const { compileString } = (await import(COMPILER)) as Compiler;
      const { binary, stderr } = await compileString(source, options);
      if (!binary) throw new Error(`${path}: ${stderr.toString()}`);
      return `export default '${Buffer.from(binary).toString('base64')}';`;
    },
  };
}

/** Names in the document what `main` imports when it runs, so that all of it loads side by side. */
function preloadPage(): Plugin {
  return {
    name: 'preload-page',
    transformIndexHtml: {
      order: 'post',
      handler(_, { bundle }) {
        const chunks = Object.values(bundle ?? {}).filter((output) => output.type === 'chunk');
        const page = chunks.find((chunk) => chunk.name === 'page');
        const entries = new Set(chunks.filter((chunk) => chunk.isEntry).map((c) => c.fileName));
        const files = page ? [page.fileName, ...page.imports] : [];
        return files
          .filter((file) => !entries.has(file))
          .map((file) => ({
            tag: 'link',
            attrs: { rel: 'modulepreload', crossorigin: true, href: `./${file}` },
            injectTo: 'head' as const,
          }));
      },
    },
  };
}

/** Lays a .br and a .gz beside each text file: the server sends them to browsers that read them. */
function compress(): Plugin {
  return {
    name: 'compress',
    apply: 'build',
    async writeBundle({ dir }, bundle) {
      const texts = Object.keys(bundle).filter((name) => COMPRESSED.test(name));
      await Promise.all(texts.map((name) => compressFile(join(dir!, name))));
    },
  };
}

const PERSON_MODEL = 'selfie_segmentation.tflite';
const PERSON_MODELS = '../server/pointbrush/masks/people/models';

/** Copies the server's model of people out of its npm package. */
function personModel(): Plugin {
  return {
    name: 'person-model',
    apply: 'build',
    async closeBundle() {
      const source = join('node_modules/@mediapipe/selfie_segmentation', PERSON_MODEL);
      await cp(source, join(PERSON_MODELS, PERSON_MODEL));
    },
  };
}

async function compressFile(path: string): Promise<void> {
  const data = await readFile(path);
  if (data.length < LEAST_BYTES) return;
  const br = { params: { [constants.BROTLI_PARAM_QUALITY]: 9 } };
  await writeFile(`${path}.br`, await promisify(brotliCompress)(data, br));
  await writeFile(`${path}.gz`, await promisify(gzip)(data, { level: 9 }));
}

export default defineConfig({
  // The server may mount the page below a path, and every asset comes from it.
  base: './',
  oxc: { jsx: { runtime: 'automatic', importSource: 'preact' } },
  plugins: [assembly(), preloadPage(), compress(), personModel()],
  build: {
    outDir: '../server/pointbrush/web/page',
    emptyOutDir: true,
    target: 'es2022',
    // Nothing inline: the page's Content-Security-Policy allows scripts and styles of its own only.
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    chunkSizeWarningLimit: 1500,
    rolldownOptions: {
      checks: { bundlerTimings: false },
      output: {
        // What others wrote changes rarely: it stays in browsers' caches, and profiles tell it apart.
        codeSplitting: {
          groups: [
            // Apart: the reader of models, for some controllers, and the writer of zip files.
            {
              name: 'three',
              test: /node_modules[\\/]three(?!.*(GLTFLoader|SkeletonUtils|fflate))/,
            },
            { name: 'libraries', test: /node_modules(?!.*(GLTFLoader|SkeletonUtils|fflate))/ },
          ],
        },
      },
    },
  },
  worker: { format: 'es', plugins: () => [assembly()] },
  test: { include: ['src/**/*.test.{ts,tsx}'] },
});

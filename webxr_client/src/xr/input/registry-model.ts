/** Models of controllers from the WebXR input profiles registry, fetched once such a controller is there. */
import { Box3, Float32BufferAttribute, Mesh, MeshBasicMaterial, TextureLoader, type BufferGeometry, type Group, type MeshStandardMaterial, type Object3D } from 'three'; // prettier-ignore
import { mergeGeometries } from 'three/examples/jsm/utils/BufferGeometryUtils.js';
import type { Device } from './devices';
import type { Spot, Spots } from './kind';
import { disposeModel, ORDER } from './model';

/** Addresses of the models, by profile and side; other devices keep the drawn model. */
const FILES = import.meta.glob<string>(
  '/node_modules/@webxr-input-profiles/assets/dist/profiles/{htc-vive,meta-quest-touch-plus,oculus-touch-v3,pico-4u}/*.glb',
  { query: '?url', import: 'default', eager: true },
);

/** Brightness of a surface that looks down, or up: the scene has no lights. */
const [SHADE, LIGHT] = [0.6, 1.3];

type Named = Pick<XRInputSource, 'profiles' | 'handedness'>;

/** Replace a drawn model by the registry's once that is there; the result gives it up. */
export function replaceModel(
  object: Object3D,
  spots: Spots,
  source: Named,
  device: Device,
): () => void {
  let wanted = true;
  const put = (scene: Group): void => {
    if (!wanted) return;
    for (const drawn of [...object.children]) disposeModel(drawn);
    scene.updateMatrixWorld(true);
    object.add(...merged(scene));
    place(spots, scene, device, source.handedness !== 'left');
  };
  const address = addressOf(source);
  // A model that cannot be fetched leaves the drawn one in its place.
  if (address) load(address).then(put, () => undefined);
  return () => {
    wanted = false;
  };
}

/** The address of a source's model; the first profile that has one decides. */
export function addressOf({ profiles, handedness }: Named): string | undefined {
  const names = profiles.flatMap((id) => [`/${id}/${handedness}.glb`, `/${id}/none.glb`]);
  const paths = names.flatMap((name) => Object.keys(FILES).filter((path) => path.endsWith(name)));
  return paths[0] && FILES[paths[0]];
}

async function load(address: string): Promise<Group> {
  const { GLTFLoader } = await import('three/examples/jsm/loaders/GLTFLoader.js');
  const loader = new GLTFLoader();
  // The page's Content-Security-Policy allows pictures from memory, and no fetches.
  loader.register((parser) => {
    parser.textureLoader = new TextureLoader(parser.options.manager);
    return { name: 'pictures' };
  });
  return (await loader.loadAsync(address)).scene;
}

/** One unlit mesh for each texture: each mesh costs its time in every picture. */
function merged(scene: Group): Mesh[] {
  const looks = new Map<unknown, MeshBasicMaterial>();
  const parts = new Map<MeshBasicMaterial, BufferGeometry[]>();
  scene.traverse((one) => {
    if (!(one instanceof Mesh)) return;
    const { map } = one.material as MeshStandardMaterial;
    const look = looks.get(map?.source) ?? new MeshBasicMaterial({ map, vertexColors: true, transparent: true }); // prettier-ignore
    looks.set(map?.source, look);
    const geometry = (one.geometry as BufferGeometry).clone().applyMatrix4(one.matrixWorld);
    parts.set(look, [...(parts.get(look) ?? []), shaded(geometry)]);
  });
  return [...parts].map(([look, geometries]) => {
    const mesh = new Mesh(mergeGeometries(geometries), look);
    mesh.renderOrder = ORDER;
    mesh.frustumCulled = false;
    return mesh;
  });
}

/** Put light from above into the vertices' colours. */
function shaded(geometry: BufferGeometry): BufferGeometry {
  const normals = geometry.getAttribute('normal');
  const colors = Float32Array.from({ length: 3 * normals.count }, (_, i) => {
    return SHADE + (LIGHT - SHADE) * (0.5 + 0.5 * normals.getY(Math.floor(i / 3)));
  });
  return geometry.deleteAttribute('normal').setAttribute('color', new Float32BufferAttribute(colors, 3));
} // prettier-ignore

/** Store the places of the controls: outer sides of their moving parts, by the registry's names. */
function place(spots: Spots, scene: Group, device: Device, right: boolean): void {
  for (const [spot, name] of Object.entries(nodeNames(device, right)) as [Spot, string][]) {
    const find = (end: string): Object3D | undefined => scene.getObjectByName(`${name}_${end}`);
    // A wand has a grip on each side.
    const control = (right && find('mirror_value')) || find('value');
    if (!control) continue;
    const { min, max } = new Box3().setFromObject(control);
    const at = spots[spot].addVectors(min, max).multiplyScalar(0.5);
    if (spot === 'trigger' || spot === 'squeeze') at.x = right ? max.x : min.x;
    else at.y = max.y;
    if (spot !== 'pad') continue;
    find('min')!.getWorldPosition(spots.up).sub(find('max')!.getWorldPosition(max)).normalize();
  }
} // prettier-ignore

/** Names of the nodes that a press moves, without their ends. */
export function nodeNames(device: Device, right: boolean): Record<Spot, string> {
  const side = right ? 0 : 1;
  const pad = device.pad === 'touchpad' ? 'touchpad' : 'thumbstick';
  return {
    trigger: 'xr_standard_trigger_pressed',
    squeeze: 'xr_standard_squeeze_pressed',
    pad: `xr_standard_${pad}_pressed`,
    primary: `${device.primaryName[side].toLowerCase()}_button_pressed`,
    secondary: `${device.secondaryName[side].toLowerCase()}_button_pressed`,
  };
}

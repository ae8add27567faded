/** Types of the WebXR Hand Input Module that @types/webxr leaves out. */
interface XRFrame {
  fillPoses?(spaces: readonly XRSpace[], base: XRSpace, transforms: Float32Array): boolean;
  fillJointRadii?(spaces: readonly XRJointSpace[], radii: Float32Array): boolean;
}

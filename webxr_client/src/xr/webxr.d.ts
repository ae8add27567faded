/** What @types/webxr leaves out of the WebXR Hand Input Module. */
interface XRFrame {
  fillPoses?(spaces: readonly XRSpace[], base: XRSpace, transforms: Float32Array): boolean;
  fillJointRadii?(spaces: readonly XRJointSpace[], radii: Float32Array): boolean;
}

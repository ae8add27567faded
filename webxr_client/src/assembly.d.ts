/** A module of AssemblyScript, compiled to WebAssembly: its bytes in base64. */
declare module '*?assembly' {
  const code: string;
  export default code;
}

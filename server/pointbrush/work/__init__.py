"""Jobs and actions of the workspace on sequences and labels together, one module each."""

"""glTF 2.0 files (.gltf, .glb): meshes, skins, morph targets and animations."""

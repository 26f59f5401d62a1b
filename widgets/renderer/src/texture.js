/* A texture from a file of a picture: its first row is the upper edge, beyond its edges it is repeated. */
import {LinearMipmapLinearFilter, RepeatWrapping, Texture} from 'three';

export async function pictureTexture(bytes) {
  const image = await createImageBitmap(new Blob([bytes]), {imageOrientation: 'flipY', premultiplyAlpha: 'none'});
  const texture = new Texture(image);
  texture.flipY = false;  /* which WebGL does for no bitmap */
  texture.wrapS = texture.wrapT = RepeatWrapping;
  texture.minFilter = LinearMipmapLinearFilter;
  texture.anisotropy = 4;
  texture.needsUpdate = true;
  return texture;
}

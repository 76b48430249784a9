// Turns a mask, white for rope, into a tint over the picture.

const TINT = [0, 220, 170];
const ALPHA = 0.5;

/** @param {Blob} png a picture with one channel */
export async function tinted(png) {
  const bitmap = await createImageBitmap(png);
  const canvas = new OffscreenCanvas(bitmap.width, bitmap.height);
  const pen = canvas.getContext("2d");
  pen.drawImage(bitmap, 0, 0);
  bitmap.close();
  const image = pen.getImageData(0, 0, canvas.width, canvas.height);
  for (let i = 0; i < image.data.length; i += 4) {
    image.data[i + 3] = ALPHA * image.data[i];
    image.data.set(TINT, i);
  }
  pen.putImageData(image, 0, 0);
  return canvas;
}
